#!/usr/bin/env python3
"""Converts maps of Nexuiz (Debian packages nexuiz-data and nexuiz-textures) to glTF, with lightmaps."""
import io
import math
import re
import struct

import numpy as np
from PIL import Image

from gltf import FLOAT, run, version
from quake3 import (
    ENTITIES, FACE, FACES, INDICES, LIGHTMAP_SIZE, LIGHTMAPS, MESH, METRES, MODEL, MODELS, PATCH, PLANAR, SHADER, SHADERS,
    SURF_NODRAW, SURF_SKY, VERTEX, VERTICES, Archives, axes, cone, from_gloss, metres, normalized, numbers, patches,
    read_entities, read_shaders, rotation_to)

EYE = 0.6  # of views above the origin of a spawn point, in metres
CANDELA = 0.15  # of an intensity of 1 in a light entity
LUX = CANDELA / METRES ** 2 / 7500  # of an intensity of 1 in a sun: q3map2's lights are 7500 × intensity / distance² (units)
RANGE = 1.2 * METRES  # of a light, in metres, per intensity
ROUGHNESS = 0.85  # of materials without a gloss map
EV100 = 1.0
LIGHTMAP_EXPOSURE = 2.6  # cd/m² of a white texel: fits the lights


class Map:
    """One map, and the glTF document that it is converted to."""

    def __init__(self, archives, shaders, name, gltf):
        self.archives, self.shaders, self.name, self.gltf = archives, shaders, name, gltf
        data = archives.read(f"maps/{name}.bsp")
        lumps = [struct.unpack_from("<ii", data, 8 + 8 * i) for i in range(17)]
        self.lump = lambda i, type_: np.frombuffer(data[lumps[i][0]:sum(lumps[i])], type_)
        self.bsp_entities = read_entities(self.lump(ENTITIES, "u1").tobytes().decode("latin1"))
        # q3map2 leaves the lights out of the BSP file.
        self.entities = read_entities(archives.text(f"maps/{name}.map")) or self.bsp_entities
        # Bytes after the zero that ends a name are undefined.
        self.shader_table = [
            (s["name"].split(b"\0")[0].decode("latin1"), int(s["surface"])) for s in self.lump(SHADERS, SHADER)]
        self.material_of, self.missing = {}, set()

    def script(self, name):
        return self.shaders.get(name.lower(), [])

    def drawn(self, name, flags):
        lines = [" ".join(line).lower() for line in self.script(name)]
        hidden = any("surfaceparm nodraw" in line or "surfaceparm sky" in line for line in lines)
        return not (hidden or flags & (SURF_NODRAW | SURF_SKY) or "common/" in name.lower())

    def origins(self, faces):
        """Returns an offset per face: models of rotating brushes are stored around the origin of their entity."""
        offsets, models = np.zeros((faces, 3)), self.lump(MODELS, MODEL)
        for entity in self.bsp_entities:
            if entity.get("model", "").startswith("*") and "origin" in entity:
                model = models[int(entity["model"][1:])]
                offsets[model["face"]:model["face"] + model["faces"]] = numbers(entity["origin"])
        return offsets

    def geometry(self):
        """Adds a mesh for each pair of shader and lightmap."""
        groups, faces = {}, self.lump(FACES, FACE)
        vertices, indices = self.lump(VERTICES, VERTEX), self.lump(INDICES, "<i4")
        for face, origin in zip(faces, self.origins(len(faces))):
            name, flags = self.shader_table[face["shader"]]
            if not self.drawn(name, flags) or face["type"] not in (PLANAR, PATCH, MESH):
                continue
            own = vertices[face["vertex"]:face["vertex"] + face["vertices"]]
            rows = np.concatenate([own["position"] + origin.astype("f4"), own["normal"], own["uv"], own["light_uv"]], 1)
            triangles = indices[face["index"]:face["index"] + face["indices"]].reshape(-1, 3)
            group = groups.setdefault((name, int(face["lightmap"])), [])
            group += patches(rows, *face["patch"]) if face["type"] == PATCH else [(rows, triangles)]
        for (name, lightmap), pieces in groups.items():
            self.mesh(name, lightmap, pieces)

    def mesh(self, name, lightmap, pieces):
        """Adds the mesh of all pieces of a shader and a lightmap: equal vertices are joined, and normals give the winding."""
        starts = np.cumsum([0] + [len(rows) for rows, _ in pieces])
        triangles = np.concatenate([t + start for (_, t), start in zip(pieces, starts)])
        rows = np.concatenate([rows for rows, _ in pieces])
        rows[:, :3], rows[:, 3:6] = metres(rows[:, :3]), axes(rows[:, 3:6])
        rows = rows.astype("f4")
        rows[:, 3:6] /= np.maximum(np.linalg.norm(rows[:, 3:6], axis=1, keepdims=True), 1e-6)
        rows[:, 6:] = np.where(abs(rows[:, 6:]) < 1e6, rows[:, 6:], 0)  # some maps have UVs that are huge or NaN
        rows, joined = np.unique(rows.round(6), axis=0, return_inverse=True)
        triangles = joined.reshape(-1)[triangles]
        a, b, c = (rows[triangles[:, i], :3] for i in range(3))
        face = np.cross(b - a, c - a)
        kept = np.linalg.norm(face, axis=1) > 1e-9
        triangles, face = triangles[kept], face[kept]
        if not len(triangles):
            return
        flip = (face * rows[triangles[:, 0], 3:6]).sum(1) < 0
        triangles[flip] = triangles[flip][:, [0, 2, 1]]
        normals = rows[:, 3:6].copy()
        normals[np.linalg.norm(normals, axis=1) < 0.5] = [0, 1, 0]  # of vertices without one, nearly all in no triangle
        normals /= np.linalg.norm(normals, axis=1, keepdims=True)
        primitive = self.gltf.primitive(rows[:, :3], normals, rows[:, 6:8], triangles, self.material(name, lightmap))
        primitive["attributes"]["TEXCOORD_1"] = self.gltf.accessor(rows[:, 8:10], FLOAT, "VEC2")
        title = f"{name}#lm{lightmap}"
        self.gltf.meshes.append({"name": title, "primitives": [primitive]})
        self.gltf.nodes.append({"mesh": len(self.gltf.meshes) - 1, "name": title})

    def base_texture(self, name):
        """Returns name and image of the base texture: the shader's own name, else its first map that exists."""
        candidates = [name]
        for words in ("map", "clampmap"), ("qer_editorimage",):
            candidates += [re.sub(r"\.(tga|jpg|png)$", "", line[1], flags=re.I) for line in self.script(name)
                           if line[0].lower() in words and len(line) > 1 and not line[1].startswith("$")]
        for candidate in candidates:
            image = self.archives.image(candidate)
            if image:
                return candidate, image
        return name, None

    def material(self, name, lightmap):
        """Returns the index of the material of a shader and a lightmap."""
        key = name, lightmap
        if key not in self.material_of:
            material = {
                "name": f"{name}#lm{lightmap}",
                "pbrMetallicRoughness": {"metallicFactor": 0.0, "roughnessFactor": ROUGHNESS},
            }
            if lightmap >= 0:
                material["extras"] = {"lightmap": lightmap_file(lightmap)}
            script = " ".join(word.lower() for line in self.script(name) for word in line)
            base, image = self.base_texture(name)
            if image:
                self.textures(material, script, base, image)
            else:
                self.missing.add(name)
            if re.search("cull (none|disable|twosided)", script):
                material["doubleSided"] = True
            self.gltf.materials.append(material)
            self.material_of[key] = len(self.gltf.materials) - 1
        return self.material_of[key]

    def textures(self, material, script, base, image):
        """Sets alpha by the script, and the textures that DarkPlaces finds by the suffixes _norm, _gloss and _glow."""
        factors, stem = material["pbrMetallicRoughness"], base.replace("/", "_")
        mask = "alphafunc" in script
        source = re.search("gl_src_alpha|blendfunc (add|blend)", script)
        blend = source and "blendfunc" in script and "surfaceparm trans" in script
        if mask or blend:
            material["alphaMode"] = "MASK" if mask else "BLEND"
            colour = self.gltf.texture((base, "RGBA"), lambda: image.convert("RGBA"), stem + "_rgba", "png")
        else:
            colour = self.gltf.texture((base, "RGB"), lambda: image.convert("RGB"), stem, "jpg")
        factors["baseColorTexture"] = colour
        normal, gloss, glow = (self.archives.image(base + suffix) for suffix in ("_norm", "_gloss", "_glow"))
        if normal:
            material["normalTexture"] = self.gltf.texture(
                (base, "normal"), lambda: normal.convert("RGB"), stem + "_norm", "png")
        if gloss:
            factors["roughnessFactor"] = 1.0
            factors["metallicRoughnessTexture"] = self.gltf.texture(
                (base, "gloss"), lambda: from_gloss(gloss), stem + "_mr", "png")
        if glow:
            material["emissiveFactor"] = [1, 1, 1]
            material["emissiveTexture"] = self.gltf.texture(
                (base, "glow"), lambda: glow.convert("RGB"), stem + "_glow", "jpg")

    def lights(self):
        """Adds the light entities; one with a target is a spot."""
        targets = {e["targetname"]: numbers(e["origin"]) for e in self.entities if "targetname" in e and "origin" in e}
        lights = [e for e in self.entities if e.get("classname", "").startswith("light") and "origin" in e]
        for i, entity in enumerate(lights):
            intensity = float((entity.get("light") or entity.get("_light") or "300").split()[-1])
            light = {"type": "point", "color": normalized(entity.get("_color", "1 1 1")), "intensity": intensity * CANDELA,
                     "range": max(1.0, intensity * RANGE)}
            origin, rotation = numbers(entity["origin"]), None
            if entity.get("target") in targets:
                toward = np.subtract(targets[entity["target"]], origin)
                light["type"], light["spot"] = "spot", cone(float(entity.get("radius", 64)), np.linalg.norm(toward))
                rotation = rotation_to(axes(toward))
            self.gltf.light(f"light{i}", metres(origin).tolist(), light, rotation)

    def views(self):
        """Returns a view from each spawn point."""
        views = []
        for entity in self.entities:
            if not entity.get("classname", "").startswith("info_player_") or "origin" not in entity:
                continue
            position = metres(numbers(entity["origin"])) + [0, EYE, 0]
            # Quake's angle is in degrees about Z, 0 along X.
            angle = math.radians(float(entity.get("angle", 0)))
            target = position + axes([math.cos(angle), math.sin(angle), 0.0])
            views.append({"position": position.round(4).tolist(), "target": target.round(4).tolist()})
        return views

    def lightmaps(self):
        """Saves the lightmaps: q3map2 writes files beside the BSP file, older compilers into it."""
        folder = self.gltf.folder / "lightmaps"
        folder.mkdir(exist_ok=True)
        for path in self.archives.names(f"maps/{self.name}/lm_", ".tga"):
            image = Image.open(io.BytesIO(self.archives.read(path))).convert("RGB")
            image.save(folder / lightmap_file(int(path.rpartition("lm_")[2][:-4])))
        for i, pixels in enumerate(self.lump(LIGHTMAPS, "u1").reshape(-1, LIGHTMAP_SIZE, LIGHTMAP_SIZE, 3)):
            Image.fromarray(pixels).save(folder / lightmap_file(i))

    def suns(self):
        """Returns the suns of the map's sky shaders: q3map_sun R G B INTENSITY DEGREES ELEVATION, degrees about Z from X."""
        suns = []
        for name, _ in self.shader_table:
            for line in self.script(name):
                if line[0].lower() in ("q3map_sun", "q3map_sunext", "sun"):
                    red, green, blue, intensity, degrees, elevation = map(float, line[1:7])
                    a, e = math.radians(degrees), math.radians(elevation)
                    toward = axes([math.cos(a) * math.cos(e), math.sin(a) * math.cos(e), math.sin(e)])
                    suns.append({"color": normalized(f"{red} {green} {blue}"), "to_sun": toward.round(6).tolist(),
                                 "lux": round(intensity * LUX, 4)})
        return suns


def lightmap_file(number):
    return f"lm_{number:04}.png"


def read_licence(path):
    """Returns the licence sentence and the copyright lines of a copyright file without a fixed format."""
    text = path.read_text("utf8")
    licence = next(p for p in re.split(r"\n\s*\n", text) if "redistribute it and/or" in p)
    return " ".join(licence.split()), [line.strip() for line in text.splitlines() if "©" in line]


class Maps:
    """The maps of the packages: each .bsp file in maps/."""

    def __init__(self, packages):
        self.packages = [packages / "nexuiz-data", packages / "nexuiz-textures"]
        self.archives = Archives(pk3 for package in self.packages for pk3 in package.glob("usr/share/games/nexuiz/data/*.pk3"))

    def names(self):
        return [path[5:-4] for path in self.archives.names("maps/", ".bsp") if "/" not in path[5:]]

    def convert(self, name, gltf):
        level = Map(self.archives, read_shaders(self.archives), name, gltf)
        level.geometry()
        level.lights()
        level.lightmaps()
        world = level.bsp_entities[0]
        info = dict(re.findall(r"^(\w+) (.*?)\s*$", self.archives.text(f"maps/{name}.mapinfo"), flags=re.M))
        licence, holders = read_licence(self.packages[0] / "usr/share/doc/nexuiz-data/copyright")
        texts = [world[key] for key in ("license", "copyright") if key in world]
        texts += filter(None, [self.archives.text(f"maps/{name}.txt")])
        return {
            "title": info.get("title") or world.get("message") or name, "authors": info.get("author") or world.get("author"),
            "package": ", ".join(map(version, self.packages)), "licence": licence, "credits": holders, "licence_texts": texts,
            "ev100": EV100, "lightmap_exposure": LIGHTMAP_EXPOSURE, "suns": level.suns(),
            # Ambient light is in the lightmaps.
            "ambient": [0, 0, 0], "sky": [0, 0, 0], "views": level.views(), "missing": sorted(level.missing),
        }


if __name__ == "__main__":
    run("nexuiz_", Maps)
