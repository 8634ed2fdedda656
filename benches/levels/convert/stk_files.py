"""Formats of SuperTuxKart's data.

One unit is one metre. SuperTuxKart is left-handed with Y up (Irrlicht); glTF's Z is the opposite.
Facts of formats: SPM meshes from src/graphics/sp_mesh_loader.cpp, rotations from Irrlicht's matrix4.h
(setRotationRadians), materials from data/shaders and data/textures/materials.xml, all of SuperTuxKart 1.4.
"""
import re
import struct
import sys
import xml.etree.ElementTree as ElementTree

import numpy as np
from PIL import Image

FLIP = np.diag([1, 1, -1, 1.0])  # glTF's space from SuperTuxKart's, and back


def read_xml(path):
    """Returns the root of an XML file; comments are removed first: some contain --, which XML forbids."""
    text = re.sub(r"<!--.*?-->", "", path.read_text("utf8", "replace"), flags=re.S)
    try:
        return ElementTree.fromstring(text)
    except ElementTree.ParseError as error:
        print(f"{path}: {error}", file=sys.stderr)
        return ElementTree.Element("empty")


def read_materials(path):
    """Returns the elements of a materials.xml by the lower-case name of their texture."""
    return {m.get("name").lower(): m for m in read_xml(path).iter("material") if m.get("name")} if path.exists() else {}


def vector(element, key, default):
    return [float(number) for number in (element.get(key) or default).split()]


def linear(colour):
    """Returns a linear colour from three sRGB numbers of 0 to 255, by a gamma of 2.2."""
    return [min(1, (float(c) / 255) ** 2.2) for c in colour.split()]


def read_spm(path):
    """Returns the buffers of an SPM mesh: (texture, positions, normals, colours, uvs, triangles), as the file has them.

    Little-endian: "SP", a byte (version 1 in its upper 5 bits, 1 below for skinned meshes), a byte of flags (1 normals,
    2 colours, 4 tangents), a bounding box of 24 bytes, a u16 count of materials (two texture names each, a length byte
    before each), a u16 count of sections, each a u16 count of buffers.
    """
    data, at = path.read_bytes(), 28

    def read(form):
        nonlocal at
        values = struct.unpack_from("<" + form, data, at)
        at += struct.calcsize("<" + form)
        return values

    def read_name():
        nonlocal at
        length, = read("B")
        at += length
        return data[at - length:at].decode("utf8", "replace")

    if data[:2] != b"SP" or data[2] >> 3 != 1:
        raise ValueError("not an SPM mesh of version 1")
    skinned, flags = data[2] & 7 == 1, data[3]
    materials = [(read_name(), read_name()) for _ in range(read("H")[0])]
    buffers = []
    for _ in range(read("H")[0]):
        for _ in range(read("H")[0]):
            vertices, indices, material = read("IIH")
            names = materials[material]
            *arrays, at = read_vertices(data, at, vertices, flags, names, skinned)
            index = np.dtype("<u2" if vertices > 255 else "u1")
            triangles = np.frombuffer(data, index, indices, at).astype("u4").reshape(-1, 3)
            at += indices * index.itemsize
            buffers.append((names[0], *arrays, triangles))
    return buffers


def read_vertices(data, start, count, flags, names, skinned):
    """Returns positions, normals, colours and uvs of a buffer, and the offset of its end.

    A vertex: 3 floats, a normal of 3 signed 10-bit numbers, a colour (the byte 128 for white, else a byte and R, G, B),
    uvs of 2 half floats for each texture that has a name, a tangent of 4 bytes after the first, 16 bytes of joints.
    """
    normals, colours, tangents = flags & 1, flags >> 1 & 1, flags >> 2 & 1
    head = 12 + 4 * normals
    tail = (4 + 4 * bool(names[1]) + 4 * tangents if names[0] else 0) + 16 * skinned
    offsets, at = np.empty(count, np.int64), start
    for i in range(count):
        offsets[i] = at
        at += head + tail + ((1 if data[at + head] == 128 else 4) if colours else 0)
    raw = np.frombuffer(data, np.uint8)

    def gather(offsets, type_, width):
        size = np.dtype(type_).itemsize * width
        return np.ascontiguousarray(raw[offsets[:, None] + np.arange(size)]).view(type_)

    position = gather(offsets, "<f4", 3)
    normal = np.tile(np.float32([0, 1, 0]), (count, 1))
    if normals:
        bits = gather(offsets + 12, "<u4", 1) >> np.uint32([0, 10, 20]) & 0x3FF
        normal = np.where(bits > 511, bits.astype("f4") - 1024, bits).astype("f4") / 511
    colour, width = np.full((count, 3), 255, np.uint8), 0
    if colours:
        tinted = raw[offsets + head] != 128
        colour[tinted] = gather(offsets[tinted] + head + 1, "u1", 3)
        width = np.where(tinted, 4, 1)
    uv = gather(offsets + head + width, "<f2", 2).astype("f4") if names[0] else np.zeros((count, 2), "f4")
    return position, normal, colour, uv, at


def matrix(element):
    """Returns the matrix of xyz, hpr (degrees about X, Y and Z, X first) and scale, for column vectors."""
    a, b, c = np.radians(vector(element, "hpr", "0 0 0"))
    (sa, sb, sc), (ca, cb, cc) = np.sin([a, b, c]), np.cos([a, b, c])
    rotation = np.array([
        [cb * cc, sa * sb * cc - ca * sc, ca * sb * cc + sa * sc],
        [cb * sc, sa * sb * sc + ca * cc, ca * sb * sc - sa * cc],
        [-sb, sa * cb, ca * cb],
    ])
    result = np.eye(4)
    result[:3, :3] = rotation * np.array(vector(element, "scale", "1 1 1"))
    result[:3, 3] = vector(element, "xyz", "0 0 0")
    return result


def decompose(transform):
    """Returns a node's translation, rotation and scale; shear, which glTF's nodes lack, is dropped: the nearest rotation."""
    scale = np.linalg.norm(transform[:3, :3], axis=0)
    r = transform[:3, :3] / np.maximum(scale, 1e-12)  # a scale of 0 hides an object
    if np.linalg.det(r) < 0:
        scale[0] *= -1
        r[:, 0] *= -1
    if abs(r.T @ r - np.eye(3)).max() > 1e-3:
        u, _, v = np.linalg.svd(r)
        r = u @ v
    diagonal = np.array([r[0, 0] - r[1, 1] - r[2, 2], r[1, 1] - r[0, 0] - r[2, 2], r[2, 2] - r[0, 0] - r[1, 1], np.trace(r)])
    signs = [r[2, 1] - r[1, 2], r[0, 2] - r[2, 0], r[1, 0] - r[0, 1], 1]
    quaternion = np.copysign(np.sqrt(np.maximum(1 + diagonal, 0)), signs)
    quaternion /= np.linalg.norm(quaternion)
    return {"translation": transform[:3, 3].tolist(), "rotation": quaternion.tolist(), "scale": scale.tolist()}


def upright(position, normal, triangles):
    """Returns a buffer in glTF's space: Z flipped, normals normalized, empty triangles removed, winding by most normals."""
    flip = np.array([1, 1, -1])
    position, normal = position * flip, normal * flip
    normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-6)
    triangles = triangles[:, [0, 2, 1]]
    a, b, c = (position[triangles[:, i]] for i in range(3))
    face = np.cross(b - a, c - a)
    kept = np.linalg.norm(face, axis=1) > 1e-10
    triangles, face = triangles[kept], face[kept]
    if len(triangles) and ((face * normal[triangles[:, 0]]).sum(1) < 0).mean() > 0.5:
        triangles = triangles[:, [0, 2, 1]]
    return position, normal, triangles


def emissive(base, emission):
    """Returns the sRGB image of base colour times emission (linear, 0 to 255)."""
    weight = Image.fromarray(emission).resize(base.size, Image.Resampling.BILINEAR)
    weight = (np.asarray(weight) / 255) ** (1 / 2.2)
    return Image.fromarray((np.asarray(base.convert("RGB")) * weight[..., None]).round().astype(np.uint8))


def read_quads(folder):
    """Returns the driveline's quads, four points each; a corner written I:J is corner J of quad I (quads.xml)."""
    quads = []
    for element in read_xml(folder / "quads.xml").iter("quad"):
        corners = []
        for key in ("p0", "p1", "p2", "p3"):
            quad, _, corner = element.get(key).partition(":")
            corners.append(quads[int(quad)][int(corner)] if corner else [float(n) for n in quad.split()])
        quads.append(corners)
    return quads


def read_copyright(path):
    """Returns paragraphs of Debian's copyright file (format 1.0): (expression for file names, licence, copyright lines)."""
    paragraphs = []
    for text in re.split(r"\n\s*\n", path.read_text("utf8")):
        fields = {}
        for key, value in re.findall(r"^(\w+):((?:.*)(?:\n[ \t].*)*)", text, flags=re.M):
            fields[key] = [line.strip() for line in value.splitlines() if line.strip()]
        if "Files" in fields:
            globs = (re.escape(g).replace(r"\*", ".*").replace(r"\?", ".") for line in fields["Files"] for g in line.split())
            paragraphs.append((re.compile("|".join(globs)), fields["License"][0], fields["Copyright"]))
    return paragraphs
