/// The scene in space: trajectories, points and segments, turned with the mouse, a finger or the buttons.
import {
  BufferGeometry, Color, Float32BufferAttribute, GridHelper, Group, LineBasicMaterial, LineSegments, Mesh,
  MeshBasicMaterial, PerspectiveCamera, Points, PointsMaterial, Scene, SphereGeometry, Vector3, WebGLRenderer,
} from 'three';
import { OrbitControls } from 'three/examples/jsm/controls/OrbitControls.js';
import { Line2 } from 'three/examples/jsm/lines/Line2.js';
import { LineGeometry } from 'three/examples/jsm/lines/LineGeometry.js';
import { LineMaterial } from 'three/examples/jsm/lines/LineMaterial.js';
import { element } from './dom.js';
import { box_of, place_at, round_step } from './space.js';
import { css_color } from './theme.js';
import { text_of } from './figures.js';

function has_webgl() {
  try {
    return document.createElement('canvas').getContext('webgl2') !== null;
  } catch {
    return false;
  }
}

export class Viewer {
  /// The canvas and its buttons are put into `place`; without WebGL a sentence is.
  constructor(place, axis, height) {
    this.place = place;
    this.axis = axis;
    this.height = height;
    this.content = new Group();
    this.markers = [];
    this.view_key = '';
    if (!has_webgl()) {
      place.append(element('p', { class: 'no-webgl' }, 'This browser has no WebGL, so there is no view in space. The view from above shows the same.'));
      return;
    }
    this.renderer = new WebGLRenderer({ antialias: true, alpha: true });
    this.renderer.setPixelRatio(Math.min(devicePixelRatio, 2));
    this.scene = new Scene();
    this.scene.add(this.content);
    this.camera = new PerspectiveCamera(45, 1, 0.01, 1000);
    const canvas = this.renderer.domElement;
    canvas.tabIndex = 0;
    canvas.setAttribute('role', 'img');
    const button = (text, title, act) => element('button', { type: 'button', title, 'aria-label': title, onclick: act }, text);
    this.hint = element('span', { class: 'hint' });
    place.append(element('div', { class: 'stage' }, canvas, element('div', { class: 'tools', role: 'group', 'aria-label': 'View' },
      button('⟲', 'Turn left', () => this.turn(-0.35)), button('⟳', 'Turn right', () => this.turn(0.35)),
      button('+', 'Closer', () => this.zoom(0.8)), button('−', 'Farther', () => this.zoom(1.25)),
      button('Top', 'From above', () => this.look_from(0.02)), button('Reset', 'The first view again', () => this.look_from(1.0)))), this.hint);
    // The wheel scrolls the page until the view has been chosen.
    canvas.addEventListener('focus', () => { this.controls.enableZoom = true; });
    canvas.addEventListener('blur', () => { this.controls.enableZoom = false; });
    canvas.addEventListener('pointerdown', () => canvas.focus({ preventScroll: true }));
    canvas.addEventListener('keydown', event => {
      const act = { ArrowLeft: () => this.turn(-0.15), ArrowRight: () => this.turn(0.15), ArrowUp: () => this.tilt(-0.12), ArrowDown: () => this.tilt(0.12),
        '+': () => this.zoom(0.85), '-': () => this.zoom(1.18) }[event.key];
      if (!act) return;
      event.preventDefault();
      event.stopPropagation();
      act();
    });
    new ResizeObserver(() => this.resize()).observe(place);
    axis.listeners.add(() => { this.place_markers(); this.render(); });
  }

  /// `scene`: {paths: [{name, t, x, y, z, color, dash, width, faint, on_top}], 
  /// points: [{positions, color, size, opacity}], segments: [{ends, color, opacity, width}], frame}; `frame`: the paths
  /// that are to be in view, all by default. The camera stays where a reader put it as long as `key` is the same.
  show(scene, view, key) {
    if (!this.renderer) return;
    const before = [...this.content.children];
    this.content.clear();
    this.fill(scene, view, key);
    for (const child of before) {  // after the new ones have come: their shaders are the same
      child.geometry?.dispose();
      child.material?.dispose();
    }
  }

  fill(scene, view, key) {
    this.markers = [];
    const box = box_of(scene.frame ?? scene.paths);
    this.hint.textContent = '';
    if (!box) {
      this.render();
      return;
    }
    const low = new Vector3(...box.low), high = new Vector3(...box.high);
    this.center = low.clone().add(high).multiplyScalar(0.5);
    this.radius = Math.max(high.distanceTo(low) / 2, 1e-3);
    for (const { positions, color, size, opacity } of scene.points)
      this.content.add(new Points(geometry_of(positions), new PointsMaterial({ color: new Color(color), size: size ?? 2.5, sizeAttenuation: false, transparent: true, opacity: opacity ?? 0.65 })));
    for (const { ends, color, opacity } of scene.segments)
      this.content.add(new LineSegments(geometry_of(ends), new LineBasicMaterial({ color: new Color(color), transparent: true, opacity: opacity ?? 0.7 })));
    for (const path of scene.paths) this.add_path(path);
    this.add_grid(box, view);
    this.renderer.domElement.setAttribute('aria-label', `In space: ${scene.paths.filter(path => !path.faint).map(path => path.name).join(', ')}. Arrow keys turn, plus and minus zoom.`);
    if (key !== this.view_key) {
      this.view_key = key;
      this.begin_view(view);
    }
    this.place_markers();
    this.resize();
  }

  add_path(path) {
    if (path.t.length < 2) return;
    const places = [];
    for (let i = 0; i < path.t.length; ++i) places.push(path.x[i], path.y[i], path.z[i]);
    const geometry = new LineGeometry();
    geometry.setPositions(places);
    const dashed = (path.dash ?? []).length > 0;
    const material = new LineMaterial({ color: new Color(path.color), linewidth: path.width ?? 2.5, transparent: true, opacity: path.faint ? 0.35 : 1, dashed,
      dashSize: dashed ? path.dash[0] * this.radius / 150 : 1, gapSize: dashed ? path.dash[1] * this.radius / 150 : 1 });
    const line = new Line2(geometry, material);
    if (dashed) line.computeLineDistances();
    if (path.on_top) {
      line.renderOrder = 1;
      material.depthTest = false;
    }
    this.content.add(line);
    if (path.faint) return;
    const ball = new Mesh(new SphereGeometry(this.radius * 0.022, 20, 14), new MeshBasicMaterial({ color: new Color(path.color) }));
    this.content.add(ball);
    this.markers.push({ path, ball });
  }

  /// At the start, or at the time that a reader chose.
  place_markers() {
    for (const { path, ball } of this.markers) {
      const here = this.axis.now === null ? [path.x[0], path.y[0], path.z[0]] : place_at(path, this.axis.now);
      ball.visible = here !== null;
      if (here) ball.position.set(...here);
    }
  }

  add_grid(box, view) {
    const size = 2.4 * this.radius, step = round_step(size, 10), cells = 2 * Math.ceil(size / 2 / step);
    const color = new Color(css_color('--grid'));
    const grid = new GridHelper(cells * step, cells, color, color);
    grid.quaternion.setFromUnitVectors(new Vector3(0, 1, 0), new Vector3(...view.up));
    const k = view.up.findIndex(value => value !== 0);
    const floor = this.center.clone().setComponent(k, view.up[k] > 0 ? box.low[k] : box.high[k]);
    grid.position.copy(floor);
    this.content.add(grid);
    this.hint.textContent = `grid of ${text_of(step, 1)} m; drag to turn, click and use the wheel to zoom`;
  }

  begin_view(view) {
    this.up = new Vector3(...view.up);
    this.right = new Vector3(view.right === 'x' ? 1 : 0, view.right === 'y' ? 1 : 0, 0);
    this.camera.up.copy(this.up);
    this.camera.near = this.radius / 200;
    this.camera.far = this.radius * 200;
    this.camera.updateProjectionMatrix();
    this.controls?.dispose();
    this.controls = new OrbitControls(this.camera, this.renderer.domElement);
    this.controls.enableZoom = document.activeElement === this.renderer.domElement;
    this.controls.addEventListener('change', () => this.render());
    this.look_from(1.0);
  }

  /// From the given angle beside the vertical.
  look_from(angle) {
    if (!this.center) return;
    const back = this.right.clone().cross(this.up);  // toward the reader
    const direction = this.up.clone().multiplyScalar(Math.cos(angle)).addScaledVector(back, Math.sin(angle)).applyAxisAngle(this.up, angle > 0.1 ? -0.5 : 0);
    const narrow = Math.min(1, this.camera.aspect || 1);
    this.controls.target.copy(this.center);
    this.camera.position.copy(this.center).addScaledVector(direction, 2.5 * this.radius / narrow);
    this.controls.update();
    this.render();
  }
  offset(change) {
    if (!this.center) return;
    const from = this.camera.position.clone().sub(this.controls.target);
    change(from);
    this.camera.position.copy(this.controls.target).add(from);
    this.controls.update();
    this.render();
  }
  turn(angle) { this.offset(from => from.applyAxisAngle(this.up, angle)); }
  tilt(angle) {
    this.offset(from => {
      const now = from.angleTo(this.up), next = Math.min(Math.max(now + angle, 0.02), 3.1);
      from.applyAxisAngle(this.up.clone().cross(from).normalize(), next - now);
    });
  }
  zoom(factor) { this.offset(from => from.multiplyScalar(factor)); }

  resize() {
    const width = this.place.clientWidth;
    if (!this.renderer || width === 0) return;
    this.renderer.setSize(width, this.height);
    this.camera.aspect = width / this.height;
    this.camera.updateProjectionMatrix();
    this.render();
  }
  render() {
    if (this.renderer && this.scene) this.renderer.render(this.scene, this.camera);
  }
}

function geometry_of(rows) {
  const geometry = new BufferGeometry();
  geometry.setAttribute('position', new Float32BufferAttribute(rows.flat(), 3));
  return geometry;
}
