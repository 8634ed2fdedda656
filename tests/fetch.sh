# To be sourced, with `cache` set to a folder: fetches packages of Debian 12 into its subfolders, never into the
# system.

# apt-get with lists and packages of its own, in a folder of the cache: apt_in FOLDER KINDS ARGUMENT…
# KINDS is deb, or "deb deb-src" where sources are wanted.
apt_in() {
    at="$cache/$1" kinds=$2
    shift 2
    command -v apt-get >/dev/null || return 1
    site=$(apt-get indextargets --format '$(SITE)' 'Codename: bookworm' | head -n 1)
    security=$(apt-get indextargets --format '$(SITE)' 'Codename: bookworm-security' | head -n 1)
    [ -n "$site" ] || return 1
    mkdir -p "$at/lists/partial" "$at/archives/partial"
    for kind in $kinds; do
        printf "$kind %s %s main\n" "$site" bookworm "$site" bookworm-backports
        [ -z "$security" ] || echo "$kind $security bookworm-security main"
    done >"$at/sources.list"
    (cd "$at" && apt-get "-oDir::Etc::SourceList=$at/sources.list" -oDir::Etc::SourceParts=/dev/null "-oDir::State::Lists=$at/lists" \
        "-oDir::Cache=$at" -oAPT::Sandbox::User=root -qq "$@")
}

# Unpacks packages of a suite into a folder of the cache, once: fetch FOLDER SUITE PACKAGE…
fetch() {
    folder=$1 suite=$2
    shift 2
    # The file lists the versions; in caches of earlier states it is empty.
    [ ! -s "$cache/$folder/complete" ] || return 0
    rm -rf "${cache:?}/$folder"
    apt_in "$folder" deb update && apt_in "$folder" deb download -t "$suite" "$@" || return 1
    for package in "$cache/$folder"/*.deb; do dpkg -x "$package" "$cache/$folder"; done
    # The versions, for those who record what they used.
    (cd "$cache/$folder" && ls ./*.deb | sed 's|^\./||; s/_amd64\.deb$//; s/%3a/:/' >complete.new)
    rm -rf "$cache/$folder"/*.deb "$cache/$folder/lists" "$cache/$folder"/*.bin
    mv "$cache/$folder/complete.new" "$cache/$folder/complete"
}
