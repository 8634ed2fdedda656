"""Formats of Quake III's family of games, as Nexuiz uses them, and their space in glTF's.

Quake's space is right-handed with Z up: glTF's X is its X, glTF's Y its Z, glTF's Z its -Y.
Facts of formats: BSP version 46 from id Software's qfiles.h (dheader_t and the structs after it), shader scripts and entity
keys from the manual and the sources of q3map2, lightmaps and suffixes of textures from DarkPlaces (model_brush.c, gl_rmain.c).
"""
import io
import math
import re
import zipfile

import numpy as np
from PIL import Image

from gltf import roughness_metallic

METRES = 1 / 40  # per unit: players are 69 units high
PATCH_STEPS = 8  # quads along each side of a 3×3 patch
SURF_SKY, SURF_NODRAW = 0x4, 0x80  # surfaceflags.h
PLANAR, PATCH, MESH = 1, 2, 3  # mapSurfaceType_t
LIGHTMAP_SIZE = 128  # of lightmaps inside the BSP file, in pixels

# Lumps of a BSP file, in the order of its header.
ENTITIES, SHADERS, MODELS, VERTICES, INDICES, FACES, LIGHTMAPS = 0, 1, 7, 10, 11, 13, 14
SHADER = np.dtype([("name", "S64"), ("surface", "<i4"), ("contents", "<i4")])
MODEL = np.dtype([("bounds", "<f4", 6), ("face", "<i4"), ("faces", "<i4"), ("brushes", "<i4", 2)])
VERTEX = np.dtype([("position", "<f4", 3), ("uv", "<f4", 2), ("light_uv", "<f4", 2), ("normal", "<f4", 3), ("colour", "u1", 4)])
FACE = np.dtype([
    ("shader", "<i4"), ("fog", "<i4"), ("type", "<i4"), ("vertex", "<i4"), ("vertices", "<i4"), ("index", "<i4"),
    ("indices", "<i4"), ("lightmap", "<i4"), ("lightmap_place", "<i4", 16), ("patch", "<i4", 2)])


class Archives:
    """Files of several .pk3 archives; names are compared without case."""

    def __init__(self, paths):
        self.entries = {}
        for path in paths:
            archive = zipfile.ZipFile(path)
            for name in archive.namelist():
                self.entries.setdefault(name.lower(), (archive, name))

    def read(self, name):
        archive, name = self.entries[name.lower()]
        return archive.read(name)

    def text(self, name):
        return self.read(name).decode("latin1") if name.lower() in self.entries else ""

    def names(self, start, end):
        return sorted(name for name in self.entries if name.startswith(start.lower()) and name.endswith(end))

    def image(self, stem):
        """Returns the image of a texture name, which has no extension; None if there is none."""
        for extension in (".tga", ".jpg", ".png", ".jpeg"):
            if (stem + extension).lower() in self.entries:
                return Image.open(io.BytesIO(self.read(stem + extension)))
        return None


def read_shaders(archives):
    """Returns the lines of each shader script, split into words; of two with one name, the first counts."""
    shaders = {}
    for path in archives.names("scripts/", ".shader"):
        text = re.sub(r"//[^\n]*|/\*.*?\*/", "", archives.text(path), flags=re.S)
        depth, title, lines = 0, None, []
        for line in re.sub(r"([{}])", r"\n\1\n", text).splitlines():
            words = line.split()
            if words == ["{"]:
                depth += 1
                lines = [] if depth == 1 else lines
            elif words == ["}"]:
                depth -= 1
                if depth == 0 and title:
                    shaders.setdefault(title.lower(), lines)
                    title = None
            elif words and depth == 0:
                title = words[-1]
            elif words:
                lines.append(words)
    return shaders


def read_entities(text):
    """Returns the keys of each entity of a .map file or an entity lump; nested brushes are skipped."""
    entities, depth = [], 0
    for line in text.splitlines():
        line = line.strip()
        if line == "{":
            depth += 1
            if depth == 1:
                entities.append({})
        elif line == "}":
            depth -= 1
        elif depth == 1:
            entities[-1].update(re.findall(r'"([^"]+)"\s+"([^"]*)"', line))
    return entities


def numbers(text):
    """Returns the numbers of a key as C's sscanf reads them, in q3map2: "0.850.85" is two."""
    return [float(number) for number in re.findall(r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?", text)]


def metres(vectors):
    """Returns points of Quake's space in glTF's, in metres."""
    return axes(vectors) * METRES


def axes(vectors):
    """Returns directions of Quake's space in glTF's."""
    vectors = np.asarray(vectors)
    return np.stack([vectors[..., 0], vectors[..., 2], -vectors[..., 1]], -1)


def patches(rows, width, height):
    """Returns the triangle pieces of a patch: each 3×3 points of its grid span a biquadratic Bézier surface."""
    t = np.linspace(0, 1, PATCH_STEPS + 1)
    basis = np.stack([(1 - t) ** 2, 2 * t * (1 - t), t ** 2], 1)
    corner = np.arange(PATCH_STEPS)[:, None] * (PATCH_STEPS + 1) + np.arange(PATCH_STEPS)
    a, b, c, d = (corner.reshape(-1) + offset for offset in (0, 1, PATCH_STEPS + 1, PATCH_STEPS + 2))
    triangles = np.stack([a, c, b, b, c, d], 1).reshape(-1, 3)
    grid, pieces = rows.reshape(height, width, -1), []
    for y in range(0, height - 2, 2):
        for x in range(0, width - 2, 2):
            piece = np.einsum("ia,jb,abk->ijk", basis, basis, grid[y:y + 3, x:x + 3]).reshape(-1, rows.shape[1])
            piece[:, 3:6] /= np.maximum(np.linalg.norm(piece[:, 3:6], axis=1, keepdims=True), 1e-6)
            pieces.append((piece, triangles))
    return pieces


def from_gloss(image):
    """Returns glTF's roughness image of a gloss map: 0.9 where there is no gloss, 0.25 at full gloss."""
    gloss = np.asarray(image.convert("L")).astype("f4") / 255
    return roughness_metallic(255, np.clip(0.9 - 0.65 * gloss, 0, 1) * 255, 0)


def normalized(colour):
    """Returns a colour whose largest component is 1, as q3map2 makes it of _color."""
    colour = (numbers(colour) + [0, 0, 0])[:3]
    return [min(1, c / (max(colour) or 1)) for c in colour]


def cone(radius, distance):
    """Returns glTF's angles of a spot: q3map2 has a cone of radius + 16 units at the target and fades the outer 32."""
    return {"outerConeAngle": math.atan2(radius + 16, distance), "innerConeAngle": math.atan2(max(radius - 16, 0), distance)}


def rotation_to(direction):
    """Returns the quaternion that turns -Z, where glTF's spots shine, to a direction."""
    x, y, z = direction / np.linalg.norm(direction)
    quaternion = np.array([y, -x, 0, 1 - z]) if z < 1 - 1e-6 else np.array([0, 1, 0, 0])
    return (quaternion / np.linalg.norm(quaternion)).tolist()
