#!/bin/sh
# Renders the pictures of the docs: docs/pictures/NAME.jpg, and small ones for the README in docs/pictures/thumbs. `figures docs` writes
# these as base64, too, for the pages of rustdoc.
#
# sh docs/pictures.sh [--only WORD] [--size WxH] [--levels FOLDER] [--out FOLDER]
#
# --only WORD      pictures with this word in their names
# --size WxH       size of what is rendered, default 1920x1080; 480x270 suits a software renderer
# --levels FOLDER  levels of free games, converted by benches/levels/fetch.sh, default target/levels; pictures of missing ones are left out
# --out FOLDER     in place of docs/pictures
#
# Builds with cargo. With BIN=FOLDER it takes the examples, `levels` and `figures` from that folder, and needs no cargo. Effects have the
# levels of `LeanPreset::High`, which are their defaults.
set -eu
root=$(cd "$(dirname "$0")/.." && pwd)
only='' size=1920x1080 levels=$root/target/levels out=$root/docs/pictures
while [ $# -gt 0 ]; do
    case $1,${2:-} in
    --only,?*) only=$2 ;;
    --size,?*) size=$2 ;;
    --levels,?*) levels=$(cd "$2" && pwd) ;;
    --out,?*) mkdir -p "$2" && out=$(cd "$2" && pwd) ;;
    *) sed -n '2,/^set/s/^# \{0,1\}//p' "$0" && exit 2 ;;
    esac
    shift 2
done
mkdir -p "$out/thumbs"
[ -z "${BIN:-}" ] || BIN=$(cd "$BIN" && pwd)
# Assets of the examples. Messages of drivers about themselves stay out of the terminal.
export BEVY_ASSET_ROOT="$root" CARGO_MANIFEST_DIR="$root" RUST_LOG="${RUST_LOG:-error}"
export MESA_VK_IGNORE_CONFORMANCE_WARNING=1 WGPU_VALIDATION="${WGPU_VALIDATION:-0}"
# The parts of pictures.
parts=$(mktemp -d)
trap 'rm -rf "$parts"' EXIT
export XDG_RUNTIME_DIR="${XDG_RUNTIME_DIR:-$parts}"
cd "$parts"

# Runs an example, `levels` or `figures`.
run() {
    program=$1
    shift
    manifest=$root/Cargo.toml
    if [ -n "${BIN:-}" ]; then
        "$BIN/$program" "$@"
    elif [ "$program" = figures ]; then
        cargo run --quiet --manifest-path "$manifest" -p bevy_lean_deferred_figures -- "$@"
    elif [ "$program" = levels ]; then
        cargo bench --quiet --manifest-path "$manifest" --profile dev --bench levels -- "$@"
    else
        cargo run --quiet --manifest-path "$manifest" --example "$program" -- "$@"
    fi
}

# part NAME EXAMPLE OPTION…: renders NAME.png, after light has bounced for some frames.
part() {
    name=$1 example=$2
    shift 2
    run "$example" --headless "$name.png" --size "$size" "$@"
}

# picture NAME [--beside] PART…: joins parts, as strips or side by side.
picture() {
    name=$1
    shift
    run figures wipe "$out/$name.jpg" "$@" --width 1920 --kilobytes 400
    echo "$out/$name.jpg"
}

# The same, and a thumbnail.
picture_and_thumb() {
    picture "$@"
    name=$1
    shift
    run figures wipe "$out/thumbs/$name.jpg" "$@" --width 480 --kilobytes 30
}

# setting NAME PART EXAMPLE FIELD "VALUE…" OPTION…: values of a field of the camera, side by side. PART is that of the picture in percent
# (left,top,width,height).
setting() {
    joined=$out/$1.jpg crop=$2 shown_by=$3 field=$4 values=$5
    shift 5
    pngs=''
    for value in $values; do
        part "value_$value" "$shown_by" "$@" --set "$field=$value"
        pngs="$pngs value_$value.png"
    done
    # shellcheck disable=SC2086 # a list of files
    run figures wipe "$joined" $pngs --beside --crop "$crop" --width 1200 --kilobytes 150
    echo "$joined"
}

ambient_occlusion() {
    set -- --dark --yaw 25 --pitch 20 --zoom 1.35
    part off ambient_occlusion "$@" --mode off --set LeanDeferred=on
    part on ambient_occlusion "$@" --set LeanDeferred=on
    part bevy ambient_occlusion "$@" --mode bevy
    part debug ambient_occlusion "$@" --set LeanDeferred=on --set LeanDebugView.shows=ambient-occlusion
    picture_and_thumb ambient_occlusion --beside off.png on.png
    picture ambient_occlusion_more --beside bevy.png debug.png
}

diffuse_gi() {
    part off screen_space --effects occlusion
    part on screen_space --set LeanScreenSpaceReflections=off
    part light screen_space --set LeanDebugView.shows=gi-light
    picture_and_thumb diffuse_gi --beside off.png on.png
    picture diffuse_gi_more light.png
}

reflections() {
    part off showcase --place puddle
    part on showcase --place puddle --set LeanScreenSpaceReflections=on
    part bevy showcase --place puddle --renderer deferred --set ScreenSpaceReflections=on
    part light showcase --place puddle --set LeanScreenSpaceReflections=on --set LeanDebugView.shows=reflection-light
    picture_and_thumb reflections --beside off.png on.png
    picture reflections_more --beside bevy.png light.png
}

subsurface_scattering() {
    part off showcase --place cats
    part on showcase --place cats --set LeanSubsurfaceScattering=on
    picture_and_thumb subsurface_scattering --beside off.png on.png
}

auto_exposure() {
    part off auto_exposure --view dark --mode off
    part on auto_exposure --view dark
    picture_and_thumb auto_exposure_dark --beside off.png on.png
    part off auto_exposure --view door --mode off
    part on auto_exposure --view door
    picture auto_exposure_door --beside off.png on.png
}

# The text of the picture has GPU times: rendered at the size in which it is shown.
many_lights() {
    small=$(echo "$size" | awk -Fx '{ print int($1 / 2) "x" int($2 / 2) }')
    run many_lights --headless lights.png --size "$small" --lights 2048 --compare
    picture many_lights lights.png
}

settings_menu() {
    run settings_menu --headless menu.png --preset high
    picture settings_menu menu.png
}

# level NAME EV VIEW: the renderers, which should look alike.
level() {
    [ -f "$levels/$1/scene.gltf" ] || return 0
    cp -R "$levels/$1" "$1"
    sed "s/\"ev100\": [-0-9.]*/\"ev100\": $2/" "$levels/$1/level.json" >"$1/level.json"
    echo "[$3]" >view.json
    run levels "$parts/$1/scene.gltf" --path view.json --views 1 --size "$size" --frames 1 --pictures .
    picture "level_$1" "$1_0_Bevy_forward.png" "$1_0_Bevy_deferred.png" "$1_0_lean.png"
}

level_nexuiz_aneurysm() {
    level nexuiz_aneurysm -1 '{"position": [9.2, 1.4, -47.8], "target": [10.2, 1.4, -47.8]}'
}

level_stk_zengarden() {
    level stk_zengarden -2 '{"position": [-161.87, 2.41, -47.95], "target": [-173.32, 2.44, -40.15]}'
}

showcase() {
    part forward showcase --place street --renderer forward
    part lean showcase --place street --set LeanScreenSpaceGi=on --set LeanScreenSpaceReflections=on --set LeanSubsurfaceScattering=on
    picture_and_thumb showcase forward.png lean.png
}

ambient_occlusion_settings() {
    set -- --dark --yaw 25 --pitch 20 --set LeanDeferred=on
    effect=LeanScreenSpaceAmbientOcclusion
    setting ambient_occlusion_radius 0,0,100,100 ambient_occlusion $effect.radius "0.1 0.5 2" "$@" --zoom 1.35
    setting ambient_occlusion_quality 28,55,25,33 ambient_occlusion $effect.quality "low medium ultra" "$@" --zoom 3
    setting ambient_occlusion_resolution 22,55,37,33 ambient_occlusion $effect.resolution "full half" "$@" --zoom 3
    setting ambient_occlusion_filter 36,60,37,33 ambient_occlusion $effect.advanced.filter "narrow wide" "$@" --zoom 6
    shift
    setting ambient_occlusion_application 5,25,50,50 ambient_occlusion $effect.application "indirect multiplicative-blend" "$@" --zoom 1.35
}

diffuse_gi_settings() {
    set -- --set LeanScreenSpaceReflections=off
    setting diffuse_gi_radius 0,0,100,100 screen_space LeanScreenSpaceGi.radius "1 4 16" "$@"
    setting diffuse_gi_intensity 0,0,100,100 screen_space LeanScreenSpaceGi.intensity "0 0.5 1" "$@"
    setting diffuse_gi_quality 17,20,25,33 screen_space LeanScreenSpaceGi.quality "low medium ultra" "$@"
    setting diffuse_gi_resolution 45,55,37,33 screen_space LeanScreenSpaceGi.resolution "half full" "$@"
}

reflections_settings() {
    effect=LeanScreenSpaceReflections
    setting reflections_thickness 12,67,25,33 screen_space $effect.thickness "0.02 0.25 5" --set LeanScreenSpaceGi=off
    setting reflections_max_roughness 0,0,100,100 showcase $effect.max_roughness "0.2 0.8" --place puddle
    setting reflections_intensity 0,0,100,100 showcase $effect.intensity "0 0.5 1" --place puddle
    setting reflections_quality 30,64,25,33 showcase $effect.quality "low medium high" --place puddle
    setting reflections_resolution 26,64,37,33 showcase $effect.resolution "half full" --place puddle
}

subsurface_scattering_settings() {
    setting subsurface_scattering_quality 30,30,37,33 showcase LeanSubsurfaceScattering.quality "low high" --place cats
}

auto_exposure_settings() {
    effect=LeanAutoExposure
    setting auto_exposure_compensation 0,0,100,100 auto_exposure $effect.compensation "-1.5 0 1.5" --view door
    setting auto_exposure_range 0,0,100,100 auto_exposure $effect.range "-8..8 -8..5 -8..3" --view dark
    setting auto_exposure_pattern 0,0,100,100 auto_exposure $effect.pattern "average center-weighted spot" --view door
}

for name in showcase ambient_occlusion diffuse_gi reflections subsurface_scattering auto_exposure many_lights settings_menu \
    ambient_occlusion_settings diffuse_gi_settings reflections_settings subsurface_scattering_settings auto_exposure_settings \
    level_nexuiz_aneurysm level_stk_zengarden; do
    case $name in
    *"$only"*) "$name" ;;
    esac
done
