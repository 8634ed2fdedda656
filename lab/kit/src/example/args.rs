//! The options that all examples have.

/// Declares the command line of an example: its own options, and those that all examples have.
#[macro_export]
macro_rules! example_args {
    ($(#[$($about:tt)*])* struct Args { $($own:tt)* }) => {
        $(#[$($about)*])*
        #[derive(argh::FromArgs)]
        struct Args {
            $($own)*

            /// a setting of the camera, such as LeanScreenSpaceGi.quality=high or LeanDebugView.shows=normal;
            /// Component=on inserts it, Component=off removes it; any number of these
            #[argh(option)]
            set: Vec<String>,

            /// switch the lights of the key L off
            #[argh(switch)]
            dark: bool,

            /// render without a window, write this PNG and quit
            #[argh(option)]
            headless: Option<String>,

            /// width x height of the picture or window
            #[argh(option, from_str_fn(kit::size::parse_size))]
            size: Option<bevy::math::UVec2>,

            /// frames before the picture is taken
            #[argh(option)]
            frames: Option<usize>,

            /// show the text in the picture of --headless too
            #[argh(switch)]
            text: bool,
        }

        impl Args {
            /// The example, with the size and the frames of pictures that it has unless told otherwise.
            fn example(
                &self,
                title: &'static str,
                size: bevy::math::UVec2,
                frames: usize,
            ) -> $crate::example::run::Example {
                $crate::example::run::Example {
                    title,
                    size: self.size.unwrap_or(size),
                    headless: self.headless.clone(),
                    text: self.text,
                    dark: self.dark,
                    set: self.set.clone(),
                    ..$crate::example::run::Example::with_frames(self.frames.unwrap_or(frames))
                }
            }
        }
    };
}
