// A picture as a texture, its bottom row first.
import * as THREE from "three";

export async function textureOf(blob) {
  const image = await createImageBitmap(blob, { imageOrientation: "flipY", colorSpaceConversion: "none" });
  const texture = new THREE.Texture(image);
  texture.flipY = false; texture.generateMipmaps = true; texture.anisotropy = 8;
  texture.wrapS = texture.wrapT = THREE.RepeatWrapping;
  texture.minFilter = THREE.LinearMipmapLinearFilter;
  texture.needsUpdate = true;
  return texture;
}
