"""Rays against objects in motion."""

import tempfile
import unittest
from pathlib import Path

import numpy as np

import sheaf

# The shutter opens at a quarter of the motion. The wall turns about its center.
SCENE = """<scene version="3.0.0">
  <sensor type="perspective"><float name="shutter_open" value="0.25"/><float name="shutter_close" value="1"/></sensor>
  <shape type="rectangle" id="wall"><animation name="to_world">
    <transform time="0"/>
    <transform time="1"> <rotate y="1" angle="40"/> <translate z="-4"/> </transform>
  </animation></shape>
  <shape type="sphere" id="ball"><animation name="to_world">
    <transform time="0"> <translate x="10"/> </transform>
    <transform time="1"> <translate x="14"/> </transform>
  </animation></shape>
  <shape type="shapegroup" id="group"> <shape type="rectangle"/> </shape>
  <shape type="instance" id="placed"> <ref id="group"/> <animation name="to_world">
    <transform time="0"> <translate x="20"/> </transform>
    <transform time="1"> <translate x="20" z="2"/> </transform>
  </animation></shape>
  <shape type="deformable" id="bent"> <string name="times" value="0, 1"/>
    <shape type="rectangle"> <transform name="to_world"> <translate x="30"/> </transform> </shape>
    <shape type="rectangle"> <transform name="to_world"> <rotate x="1" angle="60"/> <translate x="30" z="8"/>
    </transform> </shape>
  </shape>
  <emitter type="constant"/>
</scene>"""


class TraceMotion(unittest.TestCase):
    def test_objects_are_where_they_are_when_the_shutter_opens(self):
        with tempfile.TemporaryDirectory() as folder:
            file = Path(folder) / "moving.xml"
            file.write_text(SCENE, encoding="utf-8")
            scene = sheaf.load(file)
        hits = sheaf.trace(scene, [[0, 0, 2], [11, 0, 5], [11.5, 0, 5], [20, 0, 5], [30, 0, 5], [14, 0, 5]], (0, 0, -1) * np.ones((6, 1)))
        np.testing.assert_array_equal(hits.hit, [True] * 5 + [False])
        height = np.sqrt(0.75)
        np.testing.assert_allclose(hits.distance[:5], [3, 4, 5 - height, 4.5, 3], rtol=1e-4)
        np.testing.assert_allclose(hits.position[:5, 2], [-1, 1, height, 0.5, 2], rtol=1e-4)
        # Vertices of deforming meshes move along straight lines: y from 1 to 0.5, z from 0 to 8 +- sin 60
        bent = np.array([0, -np.sqrt(0.75) / 4, 1 - 0.5 / 4])
        expected = [(np.sin(np.radians(10)), 0, np.cos(np.radians(10))), (0, 0, 1), (0.5, 0, height), (0, 0, 1),
                    bent / np.linalg.norm(bent)]
        np.testing.assert_allclose(hits.normal[:5], expected, atol=1e-4)
        np.testing.assert_allclose(hits.shading_normal[:4], expected[:4], atol=1e-4)


if __name__ == "__main__":
    unittest.main()
