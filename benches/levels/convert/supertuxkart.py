#!/usr/bin/env python3
"""Converts tracks of SuperTuxKart (Debian package supertuxkart-data) to glTF."""
import math
import pathlib
import re
import struct
import xml.etree.ElementTree as ElementTree

import numpy as np
from PIL import Image

from gltf import UNSIGNED_BYTE, roughness_metallic, run, version
from stk_files import (
    FLIP, decompose, emissive, linear, matrix, read_copyright, read_materials, read_quads, read_spm, read_xml, upright, vector)

VIEW_HEIGHT = 1.5  # of views above the driveline, in metres
VIEW_DISTANCE = 3  # quads of the driveline from a view to its target
CANDELA = 25  # of a light of energy 1; pointlight.frag has 20 / (1 + d²) there, in units of its own
SUN_LUX = 1.25  # of a white sun: as sunlight.frag's unit is to pointlight.frag's, 25 / 20
AMBIENT = SUN_LUX / math.pi  # cd/m² of white ambient light, in the unit of the sun
EV100 = -1.5
ROUGHNESS = 0.9  # of materials without a gloss map
EMISSIVE = 20  # least value of a gloss map's B channel, of 255, that makes a material emissive
# Objects without a surface to draw, or with one that something else draws.
NOT_DRAWN = {"billboard", "particle_emitter", "sfx_emitter", "action_trigger", "cutscene_camera", "shadow", "cutscene"}


class Track:
    """One track, and the glTF document that it is converted to."""

    def __init__(self, data, name, gltf):
        self.data, self.folder, self.gltf = data, data / "tracks" / name, gltf
        textures = data / "textures"
        self.folders = [self.folder, textures, data / "models", textures / "deprecated", textures / "skybox"]
        self.global_materials = read_materials(textures / "deprecated/materials.xml") | read_materials(textures / "materials.xml")
        self.mesh_of, self.material_of = {}, {}
        self.used, self.missing = set(), set()

    def find(self, name, folders):
        """Returns the path of a file in the first folder that has it, ignoring case; notes it for the credits."""
        for folder in folders:
            path = folder / name
            if not path.exists() and folder.is_dir():
                path = next((p for p in folder.iterdir() if p.name.lower() == name.lower()), path)
            if path.exists():
                self.used.add(path)
                return path
        return None

    def material(self, texture, folders, local):
        """Returns the index of the material of a texture; materials.xml of the track comes before that of the game."""
        key = texture, folders[0]
        if key not in self.material_of:
            entry = local.get(texture.lower(), self.global_materials.get(texture.lower(), ElementTree.Element("material")))
            material = {"name": texture, "pbrMetallicRoughness": {"metallicFactor": 0.0, "roughnessFactor": ROUGHNESS}}
            path = self.find(texture, folders)
            if path:
                self.base_colour(material, path, texture, entry)
                self.maps(material, path, texture, entry, folders)
            else:
                self.missing.add(texture)
            self.gltf.materials.append(material)
            self.material_of[key] = len(self.gltf.materials) - 1
        return self.material_of[key]

    def base_colour(self, material, path, texture, entry):
        """Sets colour and alpha by the entry's shader (data/shaders/sps_*.xml)."""
        shader = entry.get("shader") or ""
        if shader in ("alphatest", "grass", "billboard") or not shader and entry.get("transparency") == "test":
            material["alphaMode"] = "MASK"
        elif shader in ("alphablend", "additive"):
            material["alphaMode"] = "BLEND"
        if shader == "unlit":
            material["extensions"] = {"KHR_materials_unlit": {}}
        if shader == "grass" or entry.get("backface-culling") == "N":
            material["doubleSided"] = True
        mode, extension = ("RGBA", "png") if "alphaMode" in material else ("RGB", "jpg")
        material["pbrMetallicRoughness"]["baseColorTexture"] = self.gltf.texture(
            (path, mode), lambda: Image.open(path).convert(mode), re.sub(r"\W", "_", texture), extension)

    def maps(self, material, path, texture, entry, folders):
        """Sets normal map and gloss map: R smoothness, G metallic, B emission (sp_solid.frag, combine_diffuse_color.frag)."""
        stem = re.sub(r"\W", "_", texture)
        normal = entry.get("normal-map") and self.find(entry.get("normal-map"), folders)
        if normal:
            material["normalTexture"] = self.gltf.texture(
                (normal, "normal"), lambda: Image.open(normal).convert("RGB"), stem + "_n", "png")
        gloss = entry.get("gloss-map") and self.find(entry.get("gloss-map"), folders)
        if gloss:
            smooth, metallic, emission = np.moveaxis(np.asarray(Image.open(gloss).convert("RGB")), -1, 0)
            material["pbrMetallicRoughness"] |= {
                "metallicFactor": 1.0, "roughnessFactor": 1.0,
                "metallicRoughnessTexture": self.gltf.texture(
                    (gloss, "gloss"), lambda: roughness_metallic(255, 255 - smooth, metallic), stem + "_mr", "png"),
            }
            if emission.max() > EMISSIVE:
                material["emissiveFactor"] = [1, 1, 1]
                material["emissiveTexture"] = self.gltf.texture(
                    (path, gloss, "emissive"), lambda: emissive(Image.open(path), emission), stem + "_e", "jpg")

    def mesh(self, path, folders, local):
        """Returns the index of a model's mesh, None if nothing of it is drawn."""
        if path not in self.mesh_of:
            primitives = []
            for texture, position, normal, colour, uv, triangles in read_spm(path):
                # Textures of that name mark surfaces that only collide.
                if not texture or texture.lower().startswith("invisible") or texture.lower() == "reset.png":
                    continue
                position, normal, triangles = upright(position, normal, triangles)
                if not len(triangles):
                    continue
                material = self.material(texture, folders, local)
                primitive = self.gltf.primitive(position, normal, uv, triangles, material)
                if (colour != 255).any():
                    rgb = ((colour / 255.0) ** 2.2 * 255).round()
                    rgba = np.column_stack([rgb, np.full(len(rgb), 255)]).astype(np.uint8)
                    primitive["attributes"]["COLOR_0"] = self.gltf.accessor(rgba, UNSIGNED_BYTE, "VEC4", normalized=True)
                primitives.append(primitive)
            self.mesh_of[path] = len(self.gltf.meshes) if primitives else None
            if primitives:
                self.gltf.meshes.append({"name": path.name, "primitives": primitives})
        return self.mesh_of[path]

    def place(self, model, transform, folders, local):
        """Adds a node that draws a model; transform is in SuperTuxKart's space."""
        path = self.find(model, folders)
        if not path or path.suffix != ".spm":
            self.missing.add(model)
            return
        try:
            mesh = self.mesh(path, folders, local)
        except (ValueError, struct.error) as error:
            self.missing.add(f"{model} ({error})")
            return
        if mesh is not None:
            self.gltf.nodes.append({"mesh": mesh, "name": model} | decompose(FLIP @ transform @ FLIP))

    def walk(self, root, parent, folders, local):
        """Adds objects and lights of a scene.xml, or of a library's node.xml."""
        # The first model of a group of levels of detail is the finest.
        finest = {}
        for group in root.findall("lod/group"):
            models = group.findall("static-object") + group.findall("object")
            if models:
                finest[group.get("name")] = models[0].get("model")
        for element in root.iter():
            if element.tag in ("track", "static-object", "object"):
                model = drawn_model(element, finest)
                if model:
                    self.place(model, parent @ matrix(element), folders, local)
            elif element.tag == "light":
                self.light(element, parent)
            elif element.tag == "library":
                folder = self.data / "library" / element.get("name")
                if (folder / "node.xml").exists():
                    materials = local | read_materials(folder / "materials.xml")
                    self.walk(read_xml(folder / "node.xml"), parent @ matrix(element), [folder] + folders, materials)

    def light(self, element, parent):
        position = FLIP @ parent @ np.array(vector(element, "xyz", "0 0 0") + [1])
        self.gltf.light(element.get("id") or "light", position[:3].tolist(), {
            "type": "point", "color": linear(element.get("color") or "255 255 255"),
            "intensity": float(element.get("energy", 1)) * CANDELA, "range": max(0.5, float(element.get("distance", 20)))})


def drawn_model(element, finest):
    """Returns the model that an element of a scene draws, None if it draws none."""
    if element.tag == "track":
        return element.get("model")
    if element.get("type") in NOT_DRAWN or element.get("interaction") == "physics-only":
        return None
    if element.get("lod_instance") == "true":
        return finest.get(element.get("lod_group"))
    return None if element.get("lod_group") else element.get("model")


def views(folder, scene):
    """Returns views around the main loop of graph.xml, or from the start positions of arenas.

    A node of graph.xml is the quad of its number. h is degrees about Y; at 0 a kart looks along SuperTuxKart's +Z.
    """
    if (folder / "quads.xml").exists():
        centres = np.array(read_quads(folder)).mean(1) * [1, 1, -1] + [0, VIEW_HEIGHT, 0]
        loop = read_xml(folder / "graph.xml").find("edge-loop")
        first, last = (int(loop.get("from")), int(loop.get("to"))) if loop is not None else (0, len(centres) - 1)
        centres = centres[first:last + 1].round(3)
        targets = np.roll(centres, -VIEW_DISTANCE, axis=0)
        return [{"position": p, "target": t} for p, t in zip(centres.tolist(), targets.tolist())]
    starts = []
    for start in scene.iter("start"):
        x, y, z = ([float(start.get(k)) for k in "xyz"] if start.get("x") else vector(start, "xyz", "0 0 0"))
        h = math.radians(float(start.get("h", 0)))
        position = np.array([x, y + VIEW_HEIGHT, -z])
        target = position + [math.sin(h), 0, -math.cos(h)]
        starts.append({"position": position.round(3).tolist(), "target": target.round(3).tolist()})
    return starts


def sky(scene):
    """Returns the sun and the sky of scene.xml, in linear colours; the sun's xyz is its position."""
    result = {"suns": [], "ambient": [0, 0, 0], "sky": [0, 0, 0]}
    sun, colour = scene.find(".//sun"), scene.find(".//sky-color")
    if sun is not None:
        toward = np.array(vector(sun, "xyz", "0 1 0")) * [1, 1, -1]
        toward /= max(np.linalg.norm(toward), 1e-6)
        diffuse = linear(sun.get("sun-diffuse") or "255 255 255")
        result["suns"] = [{"color": diffuse, "to_sun": toward.tolist(), "lux": SUN_LUX}]
        result["ambient"] = [c * AMBIENT for c in linear(sun.get("ambient") or "0 0 0")]
    if colour is not None:
        result["sky"] = linear(colour.get("rgb"))
    return result


def credits(paragraphs, data, used):
    """Returns the authors of the files used, grouped; of the paragraphs that fit a file, the last counts (format 1.0)."""
    groups = {}
    for path in sorted(used):
        name = str(pathlib.PurePosixPath("data") / path.relative_to(data))
        _, licence, holders = next(p for p in reversed(paragraphs) if p[0].fullmatch(name))
        groups.setdefault((licence, tuple(holders)), []).append(name)
    return [{"licence": licence, "copyright": list(holders), "files": files} for (licence, holders), files in groups.items()]


class Tracks:
    """The tracks, arenas and cutscenes of the package: each folder with a scene.xml."""

    def __init__(self, packages):
        self.package = packages / "supertuxkart-data"
        self.data = self.package / "usr/share/games/supertuxkart/data"

    def names(self):
        return [path.parent.name for path in self.data.glob("tracks/*/scene.xml")]

    def convert(self, name, gltf):
        track = Track(self.data, name, gltf)
        folder, about = track.folder, read_xml(track.folder / "track.xml")
        scene = read_xml(folder / "scene.xml")
        track.walk(scene, np.eye(4), track.folders, read_materials(folder / "materials.xml"))
        track.used.add(folder / "scene.xml")
        paragraphs = read_copyright(self.package / "usr/share/doc/supertuxkart-data/copyright")
        made_by = credits(paragraphs, self.data, track.used)
        texts = [p.read_text("utf8", "replace") for p in sorted(folder.glob("[Ll]icen[cs]e*"))]
        return {
            "title": about.get("name"), "authors": about.get("designer"), "package": version(self.package),
            "licence": ", ".join(sorted({group["licence"] for group in made_by})), "credits": made_by, "licence_texts": texts,
            "ev100": EV100, **sky(scene), "views": views(folder, scene), "missing": sorted(track.missing),
        }


if __name__ == "__main__":
    run("stk_", Tracks)
