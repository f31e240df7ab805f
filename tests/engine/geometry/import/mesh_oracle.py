#!/usr/bin/env python3
"""Reads mesh files in their plainest reading, with the standard library alone, and prints a line for each: triangles,
volume (divergence theorem), area, in the file's units, and its path. An oracle for the readers of the engine, with which
it shares no code. What it does not know (sparse numbers, skins, strips) it refuses."""
import json
import math
import pathlib
import struct
import sys
import xml.etree.ElementTree as ET
import zipfile

UNIT = [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0]]


def times(a, b):
    rows = [[sum(a[i][k] * b[k][j] for k in range(3)) for j in range(4)] for i in range(3)]
    for i in range(3):
        rows[i][3] += a[i][3]
    return rows


def place(m, p):
    return tuple(m[i][0] * p[0] + m[i][1] * p[1] + m[i][2] * p[2] + m[i][3] for i in range(3))


def determinant(m):
    (a, b, c, _), (d, e, f, _), (g, h, i, _) = m
    return a * (e * i - f * h) - b * (d * i - f * g) + c * (d * h - e * g)


def fan(points, corners):
    """A polygon as a fan: its volume and vector area are those of any other split."""
    return [(points[corners[0]], points[corners[k - 1]], points[corners[k]]) for k in range(2, len(corners))]


def placed(triangles, m):
    moved = [tuple(place(m, p) for p in t) for t in triangles]
    return [(a, c, b) for a, b, c in moved] if determinant(m) < 0 else moved


def stl(data, _):
    count = struct.unpack_from('<I', data, 80)[0] if len(data) >= 84 else -1
    if len(data) == 84 + 50 * count:
        numbers = [struct.unpack_from('<9f', data, 84 + 50 * t + 12) for t in range(count)]
        return [(n[0:3], n[3:6], n[6:9]) for n in numbers]
    words = data.decode('ascii').split()
    corners = [tuple(map(float, words[i + 1:i + 4])) for i, word in enumerate(words) if word == 'vertex']
    return list(zip(corners[0::3], corners[1::3], corners[2::3]))


def obj(data, _):
    points, triangles = [], []
    for line in data.decode('utf-8').replace('\\\n', ' ').splitlines():
        words = line.split('#')[0].split()
        if words[:1] == ['v']:
            points.append(tuple(map(float, words[1:4])))
        if words[:1] == ['f']:
            corners = [int(word.split('/')[0]) for word in words[1:]]
            triangles += fan(points, [c - 1 if c > 0 else len(points) + c for c in corners])
    return triangles


def off(data, _):
    words = data.decode('ascii').split()
    points, faces = int(words[1]), int(words[2])
    at = 4 + 3 * points
    corners = [tuple(map(float, words[4 + 3 * i:7 + 3 * i])) for i in range(points)]
    triangles = []
    for _face in range(faces):
        count = int(words[at])
        triangles += fan(corners, [int(w) for w in words[at + 1:at + 1 + count]])
        at += 1 + count
    return triangles


def ply(data, _):
    kinds = {'char': 'b', 'uchar': 'B', 'short': 'h', 'ushort': 'H', 'int': 'i', 'uint': 'I', 'float': 'f', 'double': 'd',
             'int8': 'b', 'uint8': 'B', 'int16': 'h', 'uint16': 'H', 'int32': 'i', 'uint32': 'I', 'float32': 'f', 'float64': 'd'}
    head, body = data.split(b'end_header\n', 1)
    elements, form = [], ''
    for line in head.decode('ascii').splitlines():
        words = line.split()
        if words[0] == 'format':
            form = words[1]
        if words[0] == 'element':
            elements.append((words[1], int(words[2]), []))
        if words[0] == 'property':
            elements[-1][2].append(words[1:])
    text = iter(body.split()) if form == 'ascii' else None
    at = 0

    def number(kind):
        nonlocal at
        if text is not None:
            return float(next(text))
        order = '<' if form == 'binary_little_endian' else '>'
        value = struct.unpack_from(order + kinds[kind], body, at)[0]
        at += struct.calcsize(order + kinds[kind])
        return value

    points, triangles = [], []
    for name, count, properties in elements:
        for _ in range(count):
            values = {}
            for p in properties:
                listed = p[0] == 'list'
                values[p[-1]] = [number(p[2]) for _ in range(int(number(p[1])))] if listed else number(p[0])
            if name == 'vertex':
                points.append((values['x'], values['y'], values['z']))
            if name == 'face':
                corners = values.get('vertex_indices', values.get('vertex_index'))
                triangles += fan(points, [int(c) for c in corners])
    return triangles


def threemf(_, path):
    archive = zipfile.ZipFile(path)
    core = '{http://schemas.microsoft.com/3dmanufacturing/core/2015/02}'
    production = '{http://schemas.microsoft.com/3dmanufacturing/production/2015/06}path'
    models = {}

    def model(name):
        if name not in models:
            models[name] = ET.fromstring(archive.read(name.lstrip('/')))
        return models[name]

    def transform(element):
        n = [float(w) for w in element.get('transform', '1 0 0 0 1 0 0 0 1 0 0 0').split()]
        return [[n[3 * column + row] for column in range(4)] for row in range(3)]

    def instance(element, name, m):
        name = element.get(production, name)
        x = times(m, transform(element))
        objects = {o.get('id'): o for o in model(name).iter(core + 'object')}
        body = objects[element.get('objectid')]
        points = [tuple(float(v.get(k)) for k in 'xyz') for v in body.iter(core + 'vertex')]
        found = [tuple(points[int(t.get(k))] for k in ('v1', 'v2', 'v3')) for t in body.iter(core + 'triangle')]
        triangles = placed(found, x)
        for component in body.iter(core + 'component'):
            triangles += instance(component, name, x)
        return triangles

    relations = ET.fromstring(archive.read('_rels/.rels'))
    root = next(r.get('Target') for r in relations if r.get('Type').endswith('/3dmodel'))
    return [t for item in model(root).iter(core + 'item') for t in instance(item, root, UNIT)]


def gltf(data, path):
    if data[:4] == b'glTF':
        length = struct.unpack_from('<I', data, 12)[0]
        root = json.loads(data[20:20 + length])
        chunk = data[28 + length:]
    else:
        root, chunk = json.loads(data), b''
    buffers = [chunk if 'uri' not in b else (path.parent / b['uri']).read_bytes() for b in root.get('buffers', [])]

    def numbers(index):
        a = root['accessors'][index]
        if 'sparse' in a:
            raise ValueError('sparse')
        view = root['bufferViews'][a['bufferView']]
        width = {'SCALAR': 1, 'VEC3': 3}[a['type']]
        form = '<' + str(width) + {5121: 'B', 5123: 'H', 5125: 'I', 5126: 'f'}[a['componentType']]
        begin = view.get('byteOffset', 0) + a.get('byteOffset', 0)
        stride = view.get('byteStride', struct.calcsize(form))
        return [struct.unpack_from(form, buffers[view['buffer']], begin + stride * i) for i in range(a['count'])]

    def local(node):
        if 'matrix' in node:
            return [[node['matrix'][4 * column + row] for column in range(4)] for row in range(3)]
        x, y, z, w = node.get('rotation', [0, 0, 0, 1])
        turn = [[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
                [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
                [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]]
        s, t = node.get('scale', [1, 1, 1]), node.get('translation', [0, 0, 0])
        return [[turn[i][j] * s[j] for j in range(3)] + [t[i]] for i in range(3)]

    def walk(index, m):
        node = root['nodes'][index]
        if 'skin' in node:
            raise ValueError('skins')
        x = times(m, local(node))
        triangles = []
        for primitive in root['meshes'][node['mesh']]['primitives'] if 'mesh' in node else []:
            if primitive.get('mode', 4) != 4:
                raise ValueError('strips')
            points = numbers(primitive['attributes']['POSITION'])
            order = [i[0] for i in numbers(primitive['indices'])] if 'indices' in primitive else range(len(points))
            corners = [points[i] for i in order]
            triangles += placed(list(zip(corners[0::3], corners[1::3], corners[2::3])), x)
        for child in node.get('children', []):
            triangles += walk(child, x)
        return triangles

    return [t for n in root['scenes'][root.get('scene', 0)]['nodes'] for t in walk(n, UNIT)]


def dae(data, _):
    root = ET.fromstring(data)
    space = root.tag[:root.tag.index('}') + 1]
    ids = {e.get('id'): e for e in root.iter() if e.get('id')}

    def floats(element):
        return [float(w) for w in element.text.split()]

    def shape(geometry):
        mesh = geometry.find(space + 'mesh')
        position = next(i for i in mesh.find(space + 'vertices') if i.get('semantic') == 'POSITION')
        values = floats(ids[position.get('source')[1:]].find(space + 'float_array'))
        points = list(zip(values[0::3], values[1::3], values[2::3]))
        triangles = []
        for primitive in mesh:
            kind = primitive.tag[len(space):]
            if kind not in ('triangles', 'polylist', 'polygons'):
                continue
            inputs = primitive.findall(space + 'input')
            stride = 1 + max(int(i.get('offset')) for i in inputs)
            offset = next(int(i.get('offset')) for i in inputs if i.get('semantic') == 'VERTEX')
            for p in primitive.findall(space + 'p'):
                corners = [int(w) for w in (p.text or '').split()][offset::stride]
                counts = [3] * (len(corners) // 3) if kind == 'triangles' else [len(corners)]
                if kind == 'polylist':
                    counts = [int(w) for w in primitive.find(space + 'vcount').text.split()]
                for count in counts:
                    triangles += fan(points, corners[:count])
                    corners = corners[count:]
        return triangles

    def local(node):
        x = UNIT
        for e in node:
            kind = e.tag[len(space):]
            if kind == 'matrix':
                n = floats(e)
                x = times(x, [n[0:4], n[4:8], n[8:12]])
            if kind == 'translate':
                n = floats(e)
                x = times(x, [[1, 0, 0, n[0]], [0, 1, 0, n[1]], [0, 0, 1, n[2]]])
            if kind == 'scale':
                n = floats(e)
                x = times(x, [[n[0], 0, 0, 0], [0, n[1], 0, 0], [0, 0, n[2], 0]])
            if kind == 'rotate':
                a, b, c, degrees = floats(e)
                length = math.sqrt(a * a + b * b + c * c)
                a, b, c = a / length, b / length, c / length
                s, k = math.sin(math.radians(degrees)), math.cos(math.radians(degrees))
                v = 1 - k
                x = times(x, [[k + a * a * v, a * b * v - c * s, a * c * v + b * s, 0],
                              [a * b * v + c * s, k + b * b * v, b * c * v - a * s, 0],
                              [a * c * v - b * s, b * c * v + a * s, k + c * c * v, 0]])
        return x

    def walk(node, m):
        x = times(m, local(node))
        triangles = []
        for e in node:
            kind = e.tag[len(space):]
            if kind == 'node':
                triangles += walk(e, x)
            if kind == 'instance_node':
                triangles += walk(ids[e.get('url')[1:]], x)
            if kind == 'instance_geometry':
                triangles += placed(shape(ids[e.get('url')[1:]]), x)
            if kind == 'instance_controller':
                raise ValueError('controllers')
        return triangles

    scene = ids[root.find(space + 'scene').find(space + 'instance_visual_scene').get('url')[1:]]
    return [t for node in scene if node.tag == space + 'node' for t in walk(node, UNIT)]


READERS = {'.stl': stl, '.obj': obj, '.off': off, '.ply': ply, '.3mf': threemf, '.gltf': gltf, '.glb': gltf, '.dae': dae}


def measure(triangles):
    volume = area = 0.0
    for a, b, c in triangles:
        u, v = [b[i] - a[i] for i in range(3)], [c[i] - a[i] for i in range(3)]
        n = (u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0])
        volume += sum(a[i] * n[i] for i in range(3)) / 6
        area += math.sqrt(sum(x * x for x in n)) / 2
    return volume, area


for name in sys.argv[1:]:
    file = pathlib.Path(name)
    try:
        mesh = READERS[file.suffix.lower()](file.read_bytes(), file)
        print(len(mesh), *('%.17g' % x for x in measure(mesh)), name)
    except (ArithmeticError, AttributeError, LookupError, TypeError, ValueError, struct.error, StopIteration) as why:
        print('refused', type(why).__name__, why, name)
