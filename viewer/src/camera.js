// The eye: parallel projection about a point of the die, z always up in the picture.
// SPDX-License-Identifier: Apache-2.0
import * as THREE from 'three';

const kViews = {iso: [-45, 35.264], plan: [-90, 90], front: [-90, 0], right: [0, 0]};

export class Eye {
  constructor(scene, canvas, changed) {
    this.scene = scene;
    this.canvas = canvas;
    this.changed = changed;
    this.camera = new THREE.OrthographicCamera(-1, 1, 1, -1, -1, 1);
    this.target = new THREE.Vector3();
    this.inset = 0;  // pixels at the right that the panel covers,
    this.below = 0;  // or at the bottom of a narrow page
    this.listen();
    this.look('iso');
  }

  // Direction toward the eye, and the picture's axes, in the die's.
  update() {
    const {azimuth: a, elevation: e} = this;
    this.toward = new THREE.Vector3(Math.cos(e) * Math.cos(a), Math.cos(e) * Math.sin(a), Math.sin(e));
    this.right = new THREE.Vector3(-Math.sin(a), Math.cos(a), 0);
    this.up = new THREE.Vector3().crossVectors(this.toward, this.right);
    const {camera} = this;
    const far = 4 * this.scene.size;
    camera.up.copy(this.up);
    camera.position.copy(this.target).addScaledVector(this.toward, far);
    camera.lookAt(this.target);
    const halfHeight = this.canvas.clientHeight / 2 * this.unitsPerPixel;
    const halfWidth = this.canvas.clientWidth / 2 * this.unitsPerPixel;
    const shift = this.inset / 2 * this.unitsPerPixel, rise = this.below / 2 * this.unitsPerPixel;
    Object.assign(camera, {left: -halfWidth + shift, right: halfWidth + shift, top: halfHeight - rise, bottom: -halfHeight - rise, near: 0.01 * far, far: 2 * far});
    camera.updateProjectionMatrix();
    camera.updateMatrixWorld();
    this.changed();
  }

  // Where the target is seen.
  get middle() { return [(this.canvas.clientWidth - this.inset) / 2, (this.canvas.clientHeight - this.below) / 2]; }

  look(name) {
    if (kViews[name]) [this.azimuth, this.elevation] = kViews[name].map((degrees) => degrees * Math.PI / 180);
    this.fit();
  }

  // The die as large as it goes beside the panel.
  fit() {
    const {low, high} = this.scene;
    this.target.set(...[0, 1, 2].map((k) => (low[k] + high[k]) / 2));
    this.unitsPerPixel = 1;
    this.update();
    let width = 0, height = 0;
    for (let k = 0; k < 8; ++k) {
      const p = new THREE.Vector3(k & 1 ? high[0] : low[0], k & 2 ? high[1] : low[1], k & 4 ? high[2] : low[2]).sub(this.target);
      width = Math.max(width, Math.abs(p.dot(this.right)));
      height = Math.max(height, Math.abs(p.dot(this.up)));
    }
    const room = [Math.max(50, this.canvas.clientWidth - this.inset), Math.max(50, this.canvas.clientHeight - this.below)];
    this.unitsPerPixel = Math.max(2.24 * width / room[0], 2.3 * height / room[1], 1e-9 * this.scene.size) || 1;
    this.update();
  }

  // Pixels, and how near the eye.
  project(p) {
    const d = new THREE.Vector3(p[0], p[1], p[2]).sub(this.target);
    const [x, y] = this.middle;
    return [x + d.dot(this.right) / this.unitsPerPixel, y - d.dot(this.up) / this.unitsPerPixel, d.dot(this.toward)];
  }

  // The line of sight through a pixel: a point before everything, and its direction.
  ray(x, y) {
    const [mx, my] = this.middle;
    const origin = this.target.clone()
      .addScaledVector(this.right, (x - mx) * this.unitsPerPixel)
      .addScaledVector(this.up, (my - y) * this.unitsPerPixel)
      .addScaledVector(this.toward, 4 * this.scene.size);
    return {origin, direction: this.toward.clone().negate()};
  }

  turn(dx, dy) {
    this.azimuth -= dx * 0.008;
    this.elevation = Math.min(Math.PI / 2, Math.max(-Math.PI / 2, this.elevation + dy * 0.008));
    this.update();
  }

  move(dx, dy) {
    this.target.addScaledVector(this.right, -dx * this.unitsPerPixel).addScaledVector(this.up, dy * this.unitsPerPixel);
    this.update();
  }

  // The point under (x, y) stays there.
  zoom(factor, x, y) {
    const {size} = this.scene;
    const least = 1e-7 * size, most = 0.1 * size;
    const next = Math.min(most, Math.max(least, this.unitsPerPixel * factor));
    const off = this.unitsPerPixel - next;
    const [mx, my] = this.middle;
    this.target.addScaledVector(this.right, (x - mx) * off).addScaledVector(this.up, (my - y) * off);
    this.unitsPerPixel = next;
    this.update();
  }

  listen() {
    const {canvas} = this;
    const fingers = new Map();
    let travelled = 0, moving = false;
    const middle = () => {
      const all = [...fingers.values()];
      const x = all.reduce((sum, p) => sum + p[0], 0) / all.length, y = all.reduce((sum, p) => sum + p[1], 0) / all.length;
      return {x, y, spread: all.length > 1 ? Math.hypot(all[0][0] - all[1][0], all[0][1] - all[1][1]) : 0};
    };
    canvas.addEventListener('pointerdown', (event) => {
      canvas.focus();
      canvas.setPointerCapture(event.pointerId);
      if (fingers.size === 0) travelled = 0;
      fingers.set(event.pointerId, [event.clientX, event.clientY]);
      moving = event.button !== 0 || event.shiftKey;
      canvas.classList.add('turning');
    });
    canvas.addEventListener('pointermove', (event) => {
      if (!fingers.has(event.pointerId)) return;
      const before = middle();
      fingers.set(event.pointerId, [event.clientX, event.clientY]);
      const after = middle();
      const dx = after.x - before.x, dy = after.y - before.y;
      travelled += Math.abs(dx) + Math.abs(dy);
      if (travelled < 4 && fingers.size === 1) return;
      if (fingers.size > 1) {
        if (before.spread > 0 && after.spread > 0) this.zoom(before.spread / after.spread, after.x, after.y);
        this.move(dx, dy);
      } else if (moving) {
        this.move(dx, dy);
      } else {
        this.turn(dx, dy);
      }
    });
    const end = (event) => {
      if (!fingers.delete(event.pointerId) || fingers.size > 0) return;
      canvas.classList.remove('turning');
      if (event.type === 'pointerup' && travelled < 4 && event.button === 0) this.clicked?.(event.clientX, event.clientY);
    };
    canvas.addEventListener('pointerup', end);
    canvas.addEventListener('pointercancel', end);
    canvas.addEventListener('contextmenu', (event) => event.preventDefault());
    canvas.addEventListener('wheel', (event) => {
      event.preventDefault();
      const lines = event.deltaMode === 1 ? 30 : 1;
      this.zoom(Math.exp(Math.max(-100, Math.min(100, event.deltaY * lines)) * 0.0016), event.clientX, event.clientY);
    }, {passive: false});
  }
}
