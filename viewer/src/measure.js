// The distance between two points, drawn over the picture.
// SPDX-License-Identifier: Apache-2.0
import {lengthText} from './scene.js';

const kSvg = 'http://www.w3.org/2000/svg';

export class Measure {
  constructor(scene, svg) {
    this.scene = scene;
    this.svg = svg;
    this.on = false;
    this.points = [];
    this.near = null;
  }

  // Gives the picture one more point; the third begins anew.
  add(point) {
    if (!point) return;
    if (this.points.length === 2) this.points = [];
    this.points.push(point);
    this.near = null;
  }

  clear() { this.points = []; this.near = null; }

  distances() {
    if (this.points.length < 2) return null;
    const d = [0, 1, 2].map((k) => this.points[1].point[k] - this.points[0].point[k]);
    return {d, length: Math.hypot(...d), plan: Math.hypot(d[0], d[1])};
  }

  rows() {
    const {scene} = this;
    const name = (p) => (p.element >= 0 && scene.elements[p.element].name ? scene.elements[p.element].name + ' ' : '') + (p.vertex ? '· vertex' : '· surface');
    const rows = [];
    const found = this.distances();
    if (found) {
      rows.push(['distance', lengthText(scene, found.length), 'main'], ['ΔX', lengthText(scene, found.d[0])], ['ΔY', lengthText(scene, found.d[1])],
        ['ΔZ', lengthText(scene, found.d[2])], ['in plan', lengthText(scene, found.plan)]);
    }
    for (const [k, p] of this.points.entries()) {
      rows.push([`${k + 1} ${name(p)}`, p.point.map((v) => v.toFixed(Math.min(scene.decimals, 4))).join('  ')]);
    }
    return rows;
  }

  draw(eye) {
    const parts = [];
    const add = (tag, attributes, text) => {
      const part = document.createElementNS(kSvg, tag);
      for (const [key, value] of Object.entries(attributes)) part.setAttribute(key, value);
      if (text) part.textContent = text;
      parts.push(part);
    };
    const places = this.points.map((p) => eye.project(p.drawn));
    if (places.length === 2) {
      const [[x1, y1], [x2, y2]] = places;
      add('line', {x1, y1, x2, y2});
      add('text', {x: (x1 + x2) / 2 + 10, y: (y1 + y2) / 2 - 10, 'font-size': 15}, lengthText(this.scene, this.distances().length));
    }
    for (const [cx, cy] of places) add('circle', {cx, cy, r: 5});
    if (this.near) {
      const [cx, cy] = eye.project(this.near.drawn);
      add('circle', {cx, cy, r: this.near.vertex ? 8 : 3, class: 'snap'});
    }
    this.svg.replaceChildren(...parts);
  }
}
