"""The furniture of make_hourglass.py: the brass frame, the table, the window with its curtain, and small things."""

import numpy as np

from hourglass_meshes import Mesh, box, merged, revolved, rounded, spline, surface
from hourglass_textures import fractal

MIDDLE = 12.3  # height of the hourglass's plane of symmetry
COLUMN_CIRCLE = 6.55
COLUMN_ANGLES = (66, 186, 306)

PLATE = [(0, 0.48), (6.45, 0.48), (6.55, 0.60), (6.95, 0.66), (7.25, 0.80), (7.25, 1.04), (7.02, 1.12), (7.02, 1.22),
         (6.86, 1.30), (6.62, 1.44), (6.5, 1.62), (6.42, 1.72), (5.75, 1.72), (5.70, 1.66), (5.6, 1.66), (5.55, 1.72),
         (0, 1.72)]
COLLAR = [(4.66, 1.6), (5.42, 1.6), (5.50, 1.78), (5.42, 1.94), (5.22, 2.02), (5.20, 2.10), (5.04, 2.24), (5.0, 2.46),
          (4.92, 2.56), (4.80, 2.56), (4.72, 2.46), (4.66, 2.2)]
FOOT = [(0.0, 0.0), (0.45, 0.0), (0.72, 0.14), (0.74, 0.30), (0.56, 0.44), (0.44, 0.5), (0.0, 0.52)]
COLUMN = [(0.0, 1.66), (0.50, 1.68), (0.50, 1.94), (0.40, 2.02), (0.31, 2.14), (0.31, 2.26), (0.42, 2.36), (0.42, 2.50),
          (0.28, 2.62), (0.22, 2.9), (0.25, 3.6), (0.32, 5.0), (0.375, 6.6), (0.36, 8.2), (0.28, 9.8), (0.22, 10.7),
          (0.22, 10.86), (0.36, 10.96), (0.36, 11.10), (0.25, 11.2), (0.25, 11.3), (0.40, 11.46), (0.50, 11.8),
          (0.53, 12.12), (0.53, 12.2), (0.48, 12.24), (0.48, 12.3)]


def both_ways(mesh):
    """The mesh and its reflection in the plane of symmetry."""
    mirror = Mesh(mesh.positions * (1, -1, 1) + (0, 2 * MIDDLE, 0), mesh.normals * (1, -1, 1), mesh.uvs,
                  mesh.triangles[:, ::-1])
    return merged([mesh, mirror])


def around(mesh, radius, angles):
    return merged([mesh.turned(1, a).moved((radius * np.sin(np.radians(a)), 0, radius * np.cos(np.radians(a))))
                   for a in angles])


def dense(points, step=0.02):
    """Adds points along a polyline so that normals follow its corners closely."""
    out = []
    for a, b in zip(points, points[1:]):
        count = max(1, int(np.linalg.norm(b - a) / step))
        out.append(a + np.linspace(0, 1, count, endpoint=False)[:, None] * (b - a))
    return np.vstack([*out, points[-1:]])


def make_frame(folder):
    """Writes plates with collars, columns and feet. Returns name, profile and seed of the textures of each."""
    plate = dense(rounded(PLATE, 0.09), 0.04)
    collar = dense(rounded(COLLAR, 0.07), 0.04)
    column = np.array(COLUMN)
    column = dense(rounded(np.vstack([column, (column * (1, -1) + (0, 2 * MIDDLE))[::-1][1:]]), 0.12), 0.03)
    foot = spline(FOOT, 8)
    both_ways(revolved(plate, 256)).write(folder / "plates.ply")
    both_ways(revolved(collar, 256)).write(folder / "collars.ply")
    around(revolved(column, 64), COLUMN_CIRCLE, COLUMN_ANGLES).write(folder / "columns.ply")
    both_ways(around(revolved(foot, 64), 5.85, (50, 170, 290))).write(folder / "feet.ply")
    return ("plate", plate, 200), ("collar", collar, 220), ("column", column, 240), ("foot", foot, 260)


def make_table(folder, plank=9.6, rows=3, half_length=62.0):
    """Writes planks along x. Returns the ranges of x and z that the textures cover, and the width of a plank."""
    planks = [box((-half_length, -2.6, plank * k + 0.025), (half_length, 0.0, plank * (k + 1) - 0.025), 0.11)
              for k in range(-rows, rows)]
    mesh = merged(planks)
    p = mesh.positions
    across = (p[:, 2] + p[:, 1] + rows * plank) / (2 * rows * plank)
    mesh.uvs = np.stack([(p[:, 0] + half_length) / (2 * half_length), across], -1)
    mesh.write(folder / "table.ply")
    return (-half_length, half_length), (-rows * plank, rows * plank), plank


def make_window(folder):
    """Writes the wall around the window, the window's frame and sill, and the curtain."""
    left, right, bottom, top, wall, back = -64.0, 31.0, 1.2, 64.0, -40.0, -49.0
    # Wall
    merged([box((left - 80, -90, back), (left, 110, wall), 0.3), box((right, -90, back), (right + 80, 110, wall), 0.3),
            box((left - 1, -90, back), (right + 1, bottom, wall), 0.3),
            box((left - 1, top, back), (right + 1, 110, wall), 0.3)]).write(folder / "wall.ply")
    # Frame and sill
    bars = [box((left - 1, 0.9, back), (right + 1, 3.6, back + 3.2), 0.22),
            box((left - 1, top - 3, back), (right + 1, top + 1, back + 3.2), 0.22)]
    for x, half in ((left, 3.0), (-15.5, 1.9), (right, 3.0)):
        bars.append(box((x - half, 1, back), (x + half, top, back + 3.2), 0.22))
    for y in (24.5, 46.0):
        bars.append(box((left, y - 0.7, back + 0.6), (right, y + 0.7, back + 2.4), 0.25))
    bars.append(box((-39.7, 3, back + 0.7), (-38.3, top, back + 2.3), 0.25))
    merged(bars).write(folder / "window_frame.ply")
    box((left - 3, 0.1, back + 1), (right + 3, 1.5, wall + 4.2), 0.28).write(folder / "sill.ply")
    # Curtain
    t, h = np.meshgrid(np.linspace(0, 1, 260), np.linspace(0, 1, 90), indexing="xy")
    folds = 2 * np.pi * (5.2 * t + 0.35 * np.sin(4 * t + 0.8) + 0.12 * np.sin(3.1 * h + 7 * t))
    depth = (1.35 - 0.35 * h) * (np.sin(folds) + 0.25 * np.sin(2 * folds + 1))
    depth = depth + 0.9 * (fractal(9 * t, 4 * h, octaves=5, seed=170) - 0.5)
    x = 17.0 + 21 * t + (1 - t) * (2.6 * np.sin(1.2 + 2.2 * h) - 0.6) + 0.4 * np.cos(folds)
    surface(np.stack([x, -24 + 92 * h, -33.4 + depth], -1)).write(folder / "curtain.ply")


def page_block(low, high):
    """The pages of a book: a box whose uv run along the sheets."""
    mesh = box(low, high, 0.03)
    p = mesh.positions
    mesh.uvs = np.stack([(p[:, 0] + p[:, 2]) / 40, p[:, 1] / (high[1] - low[1]) * 0.14], -1)
    return mesh


def make_book_meshes(folder, place, turn):
    """Writes the cover and the pages of a closed book of 15 x 21.5 x 3 cm with a rounded spine on the left."""
    width, length, height, board = 15.0, 21.5, 3.0, 0.28

    def placed(mesh):
        return mesh.turned(1, turn).moved(place)

    # Boards
    covers = []
    for y in (0.0, height - board):
        cover = box((-width / 2, y, -length / 2), (width / 2, y + board, length / 2), 0.07)
        p = cover.positions
        cover.uvs = np.stack([(p[:, 0] + width / 2) / width, (p[:, 2] + length / 2) / length], -1)
        covers.append(cover)
    # Spine with ribs
    angle = np.linspace(0.5 * np.pi, 1.5 * np.pi, 25)
    outline = np.stack([0.75 * np.cos(angle) - width / 2 + 0.12, height / 2 + height / 2 * np.sin(angle)], -1)
    along = np.linspace(-length / 2, length / 2, 40)
    ribs = 0.09 * sum(np.exp(-((along - r) / 0.22)**4) for r in (-7.5, -2.6, 2.6, 7.5))
    grow = (1 + ribs[:, None] / 0.75)
    spine_x = (outline[None, :, 0] + width / 2 - 0.12) * grow - width / 2 + 0.12
    spine = surface(np.stack([spine_x, outline[None, :, 1] + 0 * spine_x, along[:, None] + 0 * spine_x], -1))
    spine.uvs = spine.uvs * (0.05, 1.0) + (0.02, 0)
    covers.append(spine)
    covers.append(spine.flipped().moved((0.05, 0, 0)))
    placed(merged(covers)).write(folder / "book_cover.ply")
    # Pages
    pages = page_block((-width / 2 + 0.1, board, -length / 2 + 0.35),
                       (width / 2 - 0.35, height - board, length / 2 - 0.35))
    placed(pages).write(folder / "book_pages.ply")


def make_letter(folder, place, turn):
    x, z = np.meshgrid(np.linspace(-7.4, 7.4, 60), np.linspace(-10.4, 10.4, 80), indexing="xy")
    lift = 0.03 + 0.9 * np.clip((x - z * 0.35 - 6.8) / 6, 0, 1)**2 + 0.5 * np.clip((-x - z * 0.2 - 7.2) / 5, 0, 1)**2
    lift = lift + 0.05 * (fractal(0.2 * x, 0.2 * z, octaves=2, seed=180))
    mesh = surface(np.stack([x, lift, z], -1)).flipped()
    mesh.turned(1, turn).moved(place).write(folder / "letter.ply")


def make_pen(folder, place, turn):
    """Writes a fountain pen that lies along x: lacquer body, and metal rings, clip and nib."""
    body = spline([(0.0, -6.6), (0.30, -6.55), (0.40, -6.2), (0.50, -4.0), (0.56, -0.5), (0.57, 0.0)], 8)
    cap = spline([(0.585, 0.08), (0.60, 1.5), (0.59, 3.5), (0.52, 5.3), (0.40, 5.75), (0.0, 5.85)], 8)
    barrel = merged([revolved(dense(body, 0.1), 64), revolved(dense(cap, 0.1), 64)])
    ring = rounded([(0.50, 0.0), (0.64, 0.0), (0.64, 0.22), (0.50, 0.22)], 0.05)
    clip = box((0.585, 1.6, -0.10), (0.68, 5.35, 0.10), 0.03)
    ball = revolved(spline([(0.0, -0.14), (0.11, -0.09), (0.14, 0.0), (0.11, 0.09), (0.0, 0.14)], 6), 24)
    ball = ball.moved((0.64, 1.65, 0))
    bands = [revolved(ring, 64), revolved(ring * (1.0, 0.35) + (0.0, 0.55), 64), clip, ball,
             revolved(ring * (0.88, 1.0) + (0.0, 5.2), 64), revolved(ring * (0.75, 0.8) + (0.02, -6.1), 64)]
    for name, mesh in (("pen_body", barrel), ("pen_metal", merged(bands))):
        mesh = mesh.turned(1, -62).turned(2, -90).moved((0, 0.64, 0))
        mesh.turned(1, turn).moved(place).write(folder / f"{name}.ply")


def coin():
    """A coin with a raised rim and, on its upper face, a profile in low relief."""
    radius, thick = 1.16, 0.21
    outline = [(0.0, 0.0), (radius, 0.0), (radius, thick), (radius - 0.1, thick), (radius - 0.14, thick - 0.035),
               (0.0, thick - 0.035)]
    mesh = revolved(dense(rounded(outline, 0.025), 0.02), 128)
    p = mesh.positions
    r = np.hypot(p[:, 0], p[:, 2])
    top = (p[:, 1] > thick - 0.06) & (r < radius - 0.16)
    head = np.exp(-(((p[:, 0] + 0.05) / 0.42)**2 + ((p[:, 2] + 0.05) / 0.52)**2)**2) * 0.07
    dots = 0.03 * (np.cos(36 * np.arctan2(p[:, 2], p[:, 0])) > 0.1) * (np.abs(r - 0.9) < 0.06)
    p[:, 1] += top * (head * (0.75 + 0.6 * fractal(5 * p[:, 0], 5 * p[:, 2], octaves=3, seed=190)) + dots)
    return mesh.smoothed()


def make_coins(folder, place):
    metal = coin()
    lying = [(0.0, 0.0, 0.0), (0.10, 0.215, 0.05), (-0.05, 0.43, -0.06), (2.7, 0.0, 1.1), (-2.1, 0.0, 2.0)]
    coins = [metal.turned(1, 70 * k).moved(np.add(place, offset)) for k, offset in enumerate(lying)]
    leaning = metal.turned(2, 17).moved(np.add(place, (1.42, 0.36, -0.55)))
    merged([*coins, leaning]).write(folder / "coins.ply")


def make_town(folder, distance=900.0, count=64):
    """Writes the lights of a town in the distance: small hexagons that face the window."""
    rng = np.random.default_rng(21)
    ring = np.stack([np.cos(np.arange(6) * np.pi / 3), np.sin(np.arange(6) * np.pi / 3), np.zeros(6)], -1)
    fan = np.array([(0, k, k + 1) for k in range(1, 5)])
    lights = []
    for _ in range(count):
        x, depth = rng.normal(-40, 150), rng.uniform(0, 1) ** 1.5
        place = (x, -46 - 40 * depth + 5 * np.sin(x / 60), -distance - 40 * rng.random())
        corners = ring * rng.uniform(1.5, 2.9) + place
        lights.append(Mesh(corners, np.tile((0.0, 0.0, 1.0), (6, 1)), np.zeros((6, 2)), fan))
    merged(lights).write(folder / "town.ply")


def make_room(folder):
    make_town(folder)
    make_window(folder)
    make_book_meshes(folder, (-27.5, 0.0, -7.0), 28)
    make_letter(folder, (-19.5, 0.0, 6.5), -14)
    make_pen(folder, (-17.8, 0.06, 6.6), 24)
    make_coins(folder, (-8.6, 0.0, 9.6))
