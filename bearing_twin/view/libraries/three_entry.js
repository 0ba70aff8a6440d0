// What of three.js a page uses, in one file. To make it again, in an empty folder with this file:
//   npm install three@0.187.0 esbuild@0.28.2
//   npx esbuild three_entry.js --bundle --minify --format=iife --global-name=THREE --target=es2020 \
//     --legal-comments=inline --outfile=three.min.js
// uPlot.iife.min.js and uPlot.min.css are those of the npm package uplot@1.6.32, as they are.
export {
  BufferGeometry, CanvasTexture, Color, CylinderGeometry, DoubleSide, DynamicDrawUsage,
  ExtrudeGeometry, Float32BufferAttribute, Group, InstancedMesh, Line, LineBasicMaterial,
  LineSegments, Matrix4, Mesh, MeshBasicMaterial, MeshMatcapMaterial, PerspectiveCamera,
  Quaternion, Raycaster, ColorManagement, LinearFilter, Scene, Shape, SphereGeometry, Vector2, Vector3, WebGLRenderer,
  CircleGeometry, ConeGeometry, BoxGeometry, Box3, LatheGeometry, ShapeUtils,
} from "three";
export { OrbitControls } from "three/addons/controls/OrbitControls.js";
export { mergeGeometries } from "three/addons/utils/BufferGeometryUtils.js";
