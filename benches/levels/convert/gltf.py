"""The parts that the converters share: the glTF file, level.json and the command line."""
import argparse
import difflib
import json
import pathlib
import re
import signal
import sys
import warnings

import numpy as np
from PIL import Image

# Numbers of glTF 2.0, sections 3.6.2.2 (component types), 5.11.5 (buffer view targets) and 5.26 (samplers).
FLOAT, UNSIGNED_BYTE, UNSIGNED_SHORT, UNSIGNED_INT = 5126, 5121, 5123, 5125
VERTICES, INDICES = 34962, 34963
LINEAR_REPEAT = {"magFilter": 9729, "minFilter": 9987, "wrapS": 10497, "wrapT": 10497}
JPEG_QUALITY = 92
warnings.filterwarnings("ignore", "Palette images with Transparency")  # by Pillow, about alpha that is dropped


class Gltf:
    """A glTF document under construction: lengths in metres, Y up, right-handed."""

    def __init__(self, folder, max_texture):
        self.folder, self.max_texture = pathlib.Path(folder), max_texture
        self.binary = bytearray()
        self.views, self.accessors, self.meshes, self.nodes = [], [], [], []
        self.materials, self.textures, self.images, self.lights = [], [], [], []
        self.texture_of, self.files = {}, set()
        (self.folder / "textures").mkdir(parents=True, exist_ok=True)

    def accessor(self, array, component, kind, target=VERTICES, bounds=False, normalized=False):
        """Appends an array to scene.bin and returns the index of its accessor."""
        self.binary.extend(b"\0" * (-len(self.binary) % 4))
        data = np.ascontiguousarray(array).tobytes()
        self.views.append({"buffer": 0, "byteOffset": len(self.binary), "byteLength": len(data), "target": target})
        self.binary.extend(data)
        accessor = {"bufferView": len(self.views) - 1, "componentType": component, "count": len(array), "type": kind}
        if normalized:
            accessor["normalized"] = True
        if bounds:
            accessor |= {"min": array.min(0).tolist(), "max": array.max(0).tolist()}
        self.accessors.append(accessor)
        return len(self.accessors) - 1

    def primitive(self, positions, normals, uvs, triangles, material):
        """Returns a primitive with the attributes that all levels have; a row of triangles has three indices of vertices."""
        component, type_ = (UNSIGNED_SHORT, "<u2") if len(positions) < 65536 else (UNSIGNED_INT, "<u4")
        attributes = {
            "POSITION": self.accessor(positions.astype("<f4"), FLOAT, "VEC3", bounds=True),
            "NORMAL": self.accessor(normals.astype("<f4"), FLOAT, "VEC3"),
            "TEXCOORD_0": self.accessor(uvs.astype("<f4"), FLOAT, "VEC2"),
        }
        indices = self.accessor(triangles.reshape(-1).astype(type_), component, "SCALAR", INDICES)
        return {"attributes": attributes, "indices": indices, "material": material}

    def texture(self, source, make, name, extension):
        """Returns a reference to the texture of a key `source`; saves the image that make() returns the first time."""
        if source not in self.texture_of:
            name = re.sub(r"[^\w.+-]", "_", name)  # a # would begin a label in Bevy
            path, copy = f"textures/{name}.{extension}", 1
            while path.lower() in self.files:
                copy += 1
                path = f"textures/{name}_{copy}.{extension}"
            self.files.add(path.lower())
            image = make()
            if self.max_texture and max(image.size) > self.max_texture:
                image.thumbnail((self.max_texture, self.max_texture), Image.Resampling.LANCZOS)
            image.save(self.folder / path, **({"quality": JPEG_QUALITY} if extension == "jpg" else {}))
            self.images.append({"uri": path, "name": name})
            self.textures.append({"source": len(self.images) - 1, "sampler": 0})
            self.texture_of[source] = len(self.textures) - 1
        return {"index": self.texture_of[source]}

    def light(self, name, position, light, rotation=None):
        """Adds a KHR_lights_punctual light and its node."""
        self.lights.append(light)
        node = {"name": name, "translation": position, "extensions": {"KHR_lights_punctual": {"light": len(self.lights) - 1}}}
        self.nodes.append(node | ({"rotation": rotation} if rotation else {}))

    def save(self, generator, copyright_):
        """Writes scene.gltf and scene.bin."""
        document = {
            "asset": {"version": "2.0", "generator": generator, "copyright": copyright_},
            "scene": 0, "scenes": [{"nodes": list(range(len(self.nodes)))}], "nodes": self.nodes, "meshes": self.meshes,
            "materials": self.materials, "textures": self.textures, "images": self.images, "samplers": [LINEAR_REPEAT],
            "accessors": self.accessors, "bufferViews": self.views,
            "buffers": [{"uri": "scene.bin", "byteLength": len(self.binary)}],
        }
        used = {name for material in self.materials for name in material.get("extensions", {})}
        if self.lights:
            used.add("KHR_lights_punctual")
            document["extensions"] = {"KHR_lights_punctual": {"lights": self.lights}}
        document["extensionsUsed"] = sorted(used)
        (self.folder / "scene.bin").write_bytes(self.binary)
        # glTF forbids empty arrays.
        text = json.dumps({key: value for key, value in document.items() if value != []})
        (self.folder / "scene.gltf").write_text(text, "utf8")

    def summary(self):
        """Returns one line of counts."""
        triangles = [sum(self.accessors[p["indices"]]["count"] // 3 for p in m["primitives"]) for m in self.meshes]
        drawn = sum(triangles[node["mesh"]] for node in self.nodes if "mesh" in node)
        return (f"{drawn} triangles ({sum(triangles)} in buffers), {len(self.nodes)} nodes, {len(self.materials)} materials, "
                f"{len(self.images)} images, {len(self.lights)} lights")


def roughness_metallic(occlusion, roughness, metallic):
    """Returns glTF's image of roughness (G) and metallic (B), from three arrays or numbers of 0 to 255."""
    channels = np.broadcast_arrays(occlusion, roughness, metallic)
    return Image.fromarray(np.stack(channels, axis=-1).astype(np.uint8))


def version(package):
    """Returns a package's name and version, from the name of its .deb file that fetch.sh keeps: NAME_VERSION_all.deb."""
    name, number = (package / "complete").read_text().strip().split("_")[:2]
    return f"{name} {number.replace('%3a', ':')}"


def fail(message):
    """Ends the program with one line."""
    sys.exit(f"{pathlib.Path(sys.argv[0]).name}: {message}")


def run(prefix, open_levels):
    """Lists or converts levels: open_levels(packages) returns an object with names() and convert(name, gltf).

    convert() fills the document and returns the content of level.json, with the licence and the credits.
    """
    signal.signal(signal.SIGPIPE, signal.SIG_DFL)  # a list may be cut by head
    parser = argparse.ArgumentParser()
    parser.add_argument("packages", type=pathlib.Path, help="folder that holds each package, unpacked, in a folder of its name")
    parser.add_argument("level", nargs="?", help="without it, all are listed")
    parser.add_argument("folder", nargs="?", help="where scene.gltf is written")
    parser.add_argument("--max-texture", type=int, default=0, help="longer side of the largest texture, in pixels")
    arguments = parser.parse_args()
    levels = open_levels(arguments.packages)
    names = {prefix + name: name for name in levels.names()}
    if not arguments.level:
        print("\n".join(sorted(names)))
        return
    if arguments.level not in names:
        near = difflib.get_close_matches(arguments.level, names, n=4, cutoff=0.5)
        fail(f"no such level: {arguments.level}" + (f"; near: {' '.join(near)}" if near else ""))
    if not arguments.folder:
        fail("a folder is needed")
    gltf = Gltf(arguments.folder, arguments.max_texture)
    level = {"name": arguments.level} | levels.convert(names[arguments.level], gltf)
    gltf.save(pathlib.Path(sys.argv[0]).stem, f"{level['title']}; {level['licence']}; credits in level.json")
    (gltf.folder / "level.json").write_text(json.dumps(level, indent=1, ensure_ascii=False) + "\n", "utf8")
    print(f"{gltf.folder}/scene.gltf: {gltf.summary()}")
    if level["missing"]:
        print(f"  not found: {', '.join(level['missing'])}")
