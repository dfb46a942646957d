// Viewer of report pages: the anatomy before and after an operation, turned by one camera. Draws only when something
// changed. Without WebGL the page keeps its pictures.
import * as THREE from 'three';
import { OrbitControls } from 'three/addons/controls/OrbitControls.js';
import { GLTFLoader } from 'three/addons/loaders/GLTFLoader.js';

/** Decodes the base64 text of the element with this id. */
function bytesOf(id) {
  const text = atob(document.getElementById(id).textContent.trim());
  const bytes = new Uint8Array(text.length);
  for (let i = 0; i < text.length; ++i) bytes[i] = text.charCodeAt(i);
  return bytes.buffer;
}

/** Makes a scene of a glTF binary file, with normals and light. */
async function sceneOf(id) {
  const gltf = await new GLTFLoader().parseAsync(bytesOf(id), '');
  gltf.scene.traverse((node) => {
    if (node.isMesh) node.geometry.computeVertexNormals();
  });
  const scene = new THREE.Scene();
  scene.background = new THREE.Color(0xeef1f3);
  scene.add(gltf.scene, new THREE.HemisphereLight(0xffffff, 0x8a8f96, 1.6));
  return scene;
}

/** Shows both scenes next to each other, or one above the other in a narrow window. */
async function start() {
  const box = document.getElementById('viewer');
  if (!box) return;
  const canvas = box.querySelector('canvas');
  const renderer = new THREE.WebGLRenderer({ canvas, antialias: true });
  const scenes = await Promise.all(['glb-before', 'glb-after'].map(sceneOf));

  const bounds = new THREE.Box3();
  for (const scene of scenes) bounds.expandByObject(scene);
  const middle = bounds.getCenter(new THREE.Vector3());
  const radius = bounds.getSize(new THREE.Vector3()).length() / 2;
  // The camera looks from the mean position of the hands, moved a little sideways and up.
  const out = new THREE.Vector3(...box.dataset.from.split(',').map(Number)).sub(middle);
  if (!(out.length() > radius / 20)) out.set(0, 0, 1);
  out.normalize();
  const side = new THREE.Vector3(0, 1, 0).cross(out);
  out.addScaledVector(side, 0.35).add(new THREE.Vector3(0, 0.25, 0)).normalize();

  const camera = new THREE.PerspectiveCamera(30, 1, radius / 100, radius * 20);
  const light = new THREE.DirectionalLight(0xffffff, 1.7);
  camera.position.copy(middle).addScaledVector(out, 0.8 * radius / Math.sin((15 * Math.PI) / 180));
  const controls = new OrbitControls(camera, canvas);
  controls.target.copy(middle);
  controls.update();

  box.hidden = false;
  document.body.classList.add('has-viewer');
  let isDue = false;
  function draw() {
    isDue = false;
    const width = canvas.clientWidth, height = canvas.clientHeight;
    if (width === 0 || height === 0) return;
    const isWide = width >= height;
    const w = isWide ? width / 2 : width, h = isWide ? height : height / 2;
    renderer.setPixelRatio(Math.min(window.devicePixelRatio || 1, 2));
    renderer.setSize(width, height, false);
    renderer.setScissorTest(true);
    camera.aspect = w / h;
    camera.updateProjectionMatrix();
    light.position.copy(camera.position);
    light.target.position.copy(controls.target);
    scenes.forEach((scene, i) => {
      const x = isWide ? i * w : 0, y = isWide ? 0 : (1 - i) * h;
      renderer.setViewport(x, y, w, h);
      renderer.setScissor(x, y, w, h);
      scene.add(light, light.target);
      renderer.render(scene, camera);
    });
  }
  function request() {
    if (!isDue) requestAnimationFrame(draw);
    isDue = true;
  }
  controls.addEventListener('change', request);
  new ResizeObserver(request).observe(canvas);
  request();
}

start().catch(() => {
  document.body.classList.remove('has-viewer');
  const box = document.getElementById('viewer');
  if (box) box.hidden = true;
});
