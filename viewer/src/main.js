// The viewer: reads the page's scene, draws it, and does what the panel and the pointer ask.
// SPDX-License-Identifier: Apache-2.0
import * as THREE from 'three';
import {Eye} from './camera.js';
import {Die} from './die.js';
import {drawAxes, drawScale} from './gauges.js';
import {Measure} from './measure.js';
import {fillTable, Panel} from './panel.js';
import {Path} from './path.js';
import {hit, snapped} from './pick.js';
import {lengthText, readScene} from './scene.js';
import {Section} from './section.js';

const find = (selector) => document.querySelector(selector);

function setTheme(name) { document.documentElement.dataset.theme = name; }

function say(text) { find('#message').textContent = text; }

// True where the browser draws without a GPU, asked of a context that is thrown away.
function drawsInSoftware() {
  const gl = document.createElement('canvas').getContext('webgl');
  if (!gl) return false;
  let name = gl.getParameter(gl.RENDERER);
  const told = name === 'WebKit WebGL' ? gl.getExtension('WEBGL_debug_renderer_info') : null;
  if (told) name = gl.getParameter(told.UNMASKED_RENDERER_WEBGL);
  gl.getExtension('WEBGL_lose_context')?.loseContext();
  return /swiftshader|llvmpipe|softpipe|software|basic render/i.test(name);
}

// Smooth edges cost twice the time without a GPU, which counts where there is much to draw.
function contextFor(scene, canvas) {
  const kMuch = 400000;
  const antialias = scene.indices.length / 3 < kMuch || !drawsInSoftware();
  const context = canvas.getContext('webgl', {alpha: true, depth: true, stencil: true, antialias, premultipliedAlpha: true});
  if (!context) throw new Error('no WebGL');
  return context;
}

class Viewer {
  constructor(scene) {
    this.scene = scene;
    const canvas = find('#view');
    this.canvas = canvas;
    this.renderer = new THREE.WebGLRenderer({canvas, context: contextFor(scene, canvas)});
    this.renderer.setClearColor(0x000000, 0);
    this.renderer.setPixelRatio(Math.min(2, window.devicePixelRatio || 1));
    this.world = new THREE.Scene();
    const shared = {screen: {value: new THREE.Vector2(1, 1)}, cut: {value: new THREE.Vector4(0, 0, 0, 1)}, pixelRatio: {value: this.renderer.getPixelRatio()}};
    this.shared = shared;
    this.die = new Die(scene, this.world, shared);
    this.section = new Section(scene, this.world, this.die.shared, {value: scene.size / 90});
    this.path = scene.path ? new Path(scene, this.world, shared, this.die.shared) : null;
    this.measure = new Measure(scene, find('#marks'));
    this.coloring = scene.elements.length ? scene.coloring : 'element';
    this.rangeFactor = 1;
    this.eye = new Eye(scene, canvas, () => this.draw());
    this.eye.clicked = (x, y) => this.click(x, y);
    this.panel = new Panel(scene, this.actions());
    this.resize();
    this.eye.look('iso');
    if (this.coloring !== 'element') this.color();
    if (this.path) this.panel.setPath(this.path, false);
    canvas.addEventListener('pointermove', (event) => this.hover(event));
    window.addEventListener('resize', () => this.resize());
    window.addEventListener('keydown', (event) => this.key(event));
  }

  actions() {
    return {
      colorings: () => this.die.colorings(),
      lines: () => Object.keys(this.die.lines),
      line: (name, on) => { this.die.lines[name].visible = on; this.draw(); },
      show: (k, shown) => { this.die.show(k, shown); this.draw(); },
      select: (k) => this.select(k, null),
      near: (k) => { this.die.emphasize(this.panel.selected, k); this.draw(); },
      look: (name) => this.eye.look(name),
      color: (name) => { this.coloring = name; this.rangeFactor = 1; find('#range input').value = 0; this.color(); },
      range: (factor) => { this.rangeFactor = factor; this.color(); },
      section: (axis, at, side) => { this.section.set(axis, at, side); this.draw(); },
      along: (part) => { this.playing = false; this.setPath(() => this.path.set(part)); },
      step: (by) => { this.playing = false; this.setPath(() => this.path.step(by)); },
      play: () => this.play(),
      showPath: (what, on) => { this.path.show(what, on); this.draw(); },
      measuring: () => this.setMeasuring(!this.measure.on),
      clearMeasure: () => { this.measure.clear(); this.tellMeasure(); },
      theme: () => { setTheme(document.documentElement.dataset.theme === 'dark' ? 'light' : 'dark'); },
      resized: () => this.resize(),
    };
  }

  resize() {
    const {clientWidth: width, clientHeight: height} = this.canvas;
    this.renderer.setSize(width, height, false);
    const ratio = this.renderer.getPixelRatio();
    this.shared.screen.value.set(width * ratio, height * ratio);
    const panel = find('#panel');
    const narrow = width <= 700;
    this.eye.inset = panel.hidden || narrow ? 0 : panel.offsetWidth + 12;
    this.eye.below = panel.hidden || !narrow ? 0 : panel.offsetHeight + 8;
    this.eye.update();
  }

  // Once a frame, however often it is asked for.
  draw() {
    this.asked ??= requestAnimationFrame(() => {
      this.asked = null;
      this.drawNow();
    });
  }

  // What was asked for before would be the same picture again.
  drawAtOnce() {
    cancelAnimationFrame(this.asked);
    this.asked = null;
    this.drawNow();
  }

  drawNow() {
    this.renderer.render(this.world, this.eye.camera);
    this.measure.draw(this.eye);
    drawAxes(find('#axes'), this.eye);
    drawScale(find('#scale'), this.eye, this.scene);
  }

  color() {
    const {scene} = this;
    let range = [0, 1], ends = ['', '', ''];
    const texts = (values, digits) => values.map((v) => lengthText(scene, v, digits));
    if (this.coloring === 'height') {
      range = scene.heights;
      const own = scene.own([0, 0, 0])[2];
      ends = texts([range[0] + own, (range[0] + range[1]) / 2 + own, range[1] + own], Math.min(2, scene.decimals));
    } else if (this.coloring === 'slope') {
      ends = ['0°', '45°', '90°'];
    } else if (this.coloring === 'deviation') {
      const most = scene.deviation_scale * this.rangeFactor;
      range = [-most, most];
      ends = texts([-most, 0, most], Math.max(1, Math.ceil(1.5 - Math.log10(most))));
    } else if (this.coloring === 'cut') {
      ends = ['gouge', 'good', `over ${lengthText(scene, scene.cut.limit, Math.max(1, Math.ceil(1.5 - Math.log10(scene.cut.limit || 1))))}`];
    }
    this.die.setColoring(this.coloring, range);
    this.panel.setLegend(this.coloring, ends, this.coloring === 'deviation');
    this.draw();
  }

  found(x, y) { return hit(this.scene, this.eye.ray(x, y), (...p) => this.section.stays(...p)); }

  snap(x, y) { return snapped(this.scene, this.eye, x, y, this.found(x, y), (...p) => this.section.stays(...p)); }

  click(x, y) {
    if (this.measure.on) {
      this.measure.add(this.snap(x, y));
      this.tellMeasure();
      return;
    }
    const found = this.found(x, y);
    this.select(found ? found.element : -1, found);
  }

  select(k, found) {
    let point = null;
    if (found) {
      const middle = this.scene.own([0, 0, 0]);
      point = {point: found.point.map((v, c) => v + middle[c])};
      const code = this.scene.deviations?.[found.triangle];
      if (code !== undefined && code !== -32768) point.deviation = code * this.scene.deviation_step;
    }
    this.panel.setSelected(k, point);
    this.die.emphasize(k, -1);
    this.draw();
  }

  setMeasuring(on) {
    this.measure.on = on;
    this.measure.near = null;
    find('#measure-on').classList.toggle('on', on);
    this.canvas.classList.toggle('measuring', on);
    this.tellMeasure();
  }

  tellMeasure() {
    const left = 2 - this.measure.points.length % 2;
    find('#hint').textContent = this.measure.on ? `click ${left === 2 ? 'the first' : 'the second'} point; it snaps to vertices` : '';
    fillTable(find('#measure tbody'), this.measure.rows());
    this.draw();
  }

  hover(event) {
    if (!this.measure.on || event.buttons) return;
    this.pointer = [event.clientX, event.clientY];
    this.hovering ??= requestAnimationFrame(() => {
      this.hovering = null;
      this.measure.near = this.snap(...this.pointer);
      this.draw();
    });
  }

  setPath(change) {
    change();
    this.panel.setPath(this.path, this.playing);
    this.draw();
  }

  play() {
    this.playing = !this.playing;
    if (this.playing && this.path.place >= 1) this.path.set(0);
    let before = performance.now();
    const tick = (now) => {
      if (!this.playing) return;
      const seconds = Math.max(0, now - before) / 1000;
      before = now;
      if (this.path.place >= 1) this.playing = false;
      this.setPath(() => this.path.advance(seconds, this.panel.speed));
      if (this.playing) requestAnimationFrame(tick);
    };
    requestAnimationFrame(tick);
    this.panel.setPath(this.path, this.playing);
  }

  key(event) {
    if (event.ctrlKey || event.metaKey || event.altKey || /^(INPUT|SELECT)$/.test(event.target.tagName)) return;
    const views = {0: 'iso', 1: 'plan', 2: 'front', 3: 'right', f: 'fit'};
    const pressed = event.key.toLowerCase();
    if (views[pressed]) this.eye.look(views[pressed]);
    else if (pressed === 'm' && this.scene.elements.length) this.setMeasuring(!this.measure.on);
    else if (pressed === 'escape') { this.setMeasuring(false); this.select(-1, null); }
    else if (pressed === 'tab' && event.target === this.canvas) { event.preventDefault(); this.panel.toggle(); }
    else if (pressed === ' ' && this.path && event.target.tagName !== 'BUTTON') { event.preventDefault(); this.play(); }
    else if (pressed === 'arrowright' && this.path) this.setPath(() => this.path.step(1));
    else if (pressed === 'arrowleft' && this.path) this.setPath(() => this.path.step(-1));
  }
}

async function open() {
  setTheme(window.matchMedia('(prefers-color-scheme: dark)').matches ? 'dark' : 'light');
  if (typeof DecompressionStream === 'undefined') throw new Error('this browser is too old: it has no DecompressionStream (2023)');
  // The words on the screen before the work begins.
  await new Promise((done) => { requestAnimationFrame(() => setTimeout(done)); });
  const scene = await readScene(find('#head').textContent, find('#body').textContent);
  find('#body').remove();
  const viewer = new Viewer(scene);
  viewer.drawAtOnce();
  // A pixel read back is a picture that is done.
  const gl = viewer.renderer.getContext();
  gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, new Uint8Array(4));
  say('');
  window.diesink = {viewer, seconds: performance.now() / 1000};
  document.documentElement.dataset.state = 'open';
}

open().catch((error) => {
  console.error(error);
  const noGraphics = /WebGL/.test(error.message);
  say(noGraphics ? 'This browser has no WebGL, which the view needs.' : `The page cannot be shown: ${error.message}`);
  document.documentElement.dataset.state = 'failed';
});
