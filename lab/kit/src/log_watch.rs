//! Records this process's messages for tests.

use core::fmt::{Debug, Write};
use std::sync::Mutex;

use bevy::log::tracing_subscriber::{Layer, Registry, layer::Context};
use tracing::{
    Event, Level,
    field::{Field, Visit},
};

static MESSAGES: Mutex<Vec<(Level, String)>> = Mutex::new(Vec::new());

/// Messages so far of such levels that contain `part`.
fn messages(is_wanted: impl Fn(Level) -> bool, part: &str) -> Vec<String> {
    let messages = MESSAGES.lock().unwrap_or_else(|poison| poison.into_inner());
    (messages.iter())
        .filter(|(level, message)| is_wanted(*level) && message.contains(part))
        .map(|(_, message)| message.clone())
        .collect()
}

/// Warnings and errors so far that contain `part`, without false alarms of an old validation layer.
pub fn messages_with(part: &str) -> Vec<String> {
    let mut messages = messages(|level| level <= Level::WARN, part);
    messages.retain(|message| !tells_of_unknown_structure(message));
    messages
}

/// Notes so far that contain `part`, which are neither warnings nor errors. For apps whose log has them.
pub fn notes_with(part: &str) -> Vec<String> {
    messages(|level| level == Level::INFO, part)
}

/// Parts of the message about a structure that newer drivers know and an old validation layer does not: Debian's is of 2022, and wgpu
/// passes `VkPhysicalDeviceRayTracingPositionFetchFeaturesKHR` to drivers that offer it.
const UNKNOWN_STRUCTURE: [&str; 2] = [
    "VUID-VkDeviceCreateInfo-pNext-pNext",
    "unknown VkStructureType (1000481000)",
];

fn tells_of_unknown_structure(message: &str) -> bool {
    UNKNOWN_STRUCTURE.iter().all(|part| message.contains(part))
}

/// Complaints of the Vulkan validation layer. wgpu loads it in builds with debug assertions, if installed.
pub fn validation_layer_complaints() -> Vec<String> {
    messages_with("VUID")
}

/// Panics if the Vulkan validation layer has complained. `tests/apps/validation_layer.rs` shows that complaints are recorded.
pub fn assert_validation_layer_silent() {
    let complaints = validation_layer_complaints();
    assert!(complaints.is_empty(), "{}", complaints.join("\n"));
}

/// Records errors, warnings and notes.
pub struct LogWatch;

impl Layer<Registry> for LogWatch {
    fn on_event(&self, event: &Event, _: Context<Registry>) {
        let level = *event.metadata().level();
        if level > Level::INFO {
            return;
        }
        let mut text = Text(String::new());
        event.record(&mut text);
        let mut messages = MESSAGES.lock().unwrap_or_else(|poison| poison.into_inner());
        messages.push((level, text.0));
    }
}

struct Text(String);

impl Visit for Text {
    fn record_debug(&mut self, field: &Field, value: &dyn Debug) {
        if field.name() == "message" {
            let _ = write!(self.0, "{value:?}");
        }
    }
}
