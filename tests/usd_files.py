"""Rigs for USD, the validators, and a file such as other programs write."""

from dataclasses import replace
from pathlib import Path

import numpy as np

import gltf_files
from mien.rig import Performance, Rig

NAMES = ("jawOpen", "jaw Open", "2nd über", "a:b")
"""Names of which USD takes one alone for a prim; two of them are one identifier."""


def rig() -> Rig:
    texture = np.random.default_rng(0).integers(0, 255, (16, 16, 3), np.uint8)
    return replace(gltf_files.rig(), names=NAMES, texture=texture)


def performance(rate: float = 59.94) -> Performance:
    return replace(gltf_files.performance(), rig=rig(), rate=rate)


def complaints(path: Path) -> list[str]:
    """What USD's own validators, all of them, say about a file."""
    from pxr import Usd, UsdValidation

    validators = UsdValidation.ValidationRegistry().GetOrLoadAllValidators()
    context = UsdValidation.ValidationContext(validators)
    return [error.GetErrorAsString() for error in context.Validate(Usd.Stage.Open(str(path)))]


FOREIGN = """#usda 1.0
( upAxis = "Z"
  metersPerUnit = 0.01
  timeCodesPerSecond = 24
  startTimeCode = 1 )
def Xform "world" {
  double3 xformOp:translate.timeSamples = { 1: (0, 0, 0), 3: (0, 0, 4) }
  uniform token[] xformOpOrder = ["xformOp:translate"]
  def SkelRoot "root" (prepend apiSchemas = ["SkelBindingAPI"]) {
    rel skel:animationSource = </world/root/anim>
    rel skel:skeleton = </world/root/skel>
    def Skeleton "skel" (prepend apiSchemas = ["SkelBindingAPI"]) {
      uniform token[] joints = ["a"]
      uniform matrix4d[] bindTransforms = [((1,0,0,0),(0,1,0,0),(0,0,1,0),(0,0,0,1))]
      uniform matrix4d[] restTransforms = [((1,0,0,0),(0,1,0,0),(0,0,1,0),(0,0,0,1))]
      rel skel:animationSource = </world/root/anim>
    }
    def SkelAnimation "anim" {
      uniform token[] blendShapes = ["frown", "smile"]
      float[] blendShapeWeights.timeSamples = { 1: [0, 0.5], 2: [0.25, 0.5], 3: [0.5, 1] }
    }
    def Mesh "quad" (prepend apiSchemas = ["SkelBindingAPI"]) {
      uniform token orientation = "leftHanded"
      int[] faceVertexCounts = [4]
      int[] faceVertexIndices = [0, 1, 2, 3]
      point3f[] points = [(0, 0, 0), (1, 0, 0), (1, 0, 1), (0, 0, 1)]
      texCoord2f[] primvars:map1 = [(0, 0), (1, 0), (1, 1), (0, 1)] ( interpolation = "faceVarying" )
      uniform token[] skel:blendShapes = ["smile", "frown", "unused"]
      rel skel:blendShapeTargets = [</world/root/quad/s1>, </world/root/quad/s2>, </world/root/quad/s3>]
      def BlendShape "s1" {
        uniform vector3f[] offsets = [(0, 0, 1)]
        uniform int[] pointIndices = [2]
      }
      def BlendShape "s2" {
        uniform vector3f[] offsets = [(0, 0, -1), (0, 0, -1), (0, 0, -1), (0, 0, -1)]
        uniform vector3f[] inbetweens:half = [(0, 0, 0), (0, 0, 0), (0, 0, 0), (0, 0, 0)] ( weight = 0.5 )
      }
      def BlendShape "s3" {
        uniform vector3f[] offsets = []
        uniform int[] pointIndices = []
      }
    }
  }
}
"""


def foreign(path: Path, **change: str) -> Path:
    """A quad in centimetres, +Z up, wound the other way, moved by its parent; pieces of the text replaced."""
    text = FOREIGN
    for old, new in change.items():
        assert old in text
        text = text.replace(old, new)
    path.write_text(text)
    return path
