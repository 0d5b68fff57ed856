// The panel beside the picture: what it shows follows from the scene, what it changes goes through `act`.
// SPDX-License-Identifier: Apache-2.0
import {scalePixels} from './colors.js';
import {lengthText, shortUnit} from './scene.js';

const find = (selector) => document.querySelector(selector);

export function fillTable(body, rows) {
  body.replaceChildren(...rows.map(([name, value, kind]) => {
    const row = document.createElement('tr');
    if (kind) row.className = kind;
    for (const text of [name, value]) row.insertCell().textContent = text;
    return row;
  }));
}

function checkbox(text, checked, changed) {
  const label = document.createElement('label');
  const box = Object.assign(document.createElement('input'), {type: 'checkbox', checked});
  box.addEventListener('change', () => changed(box.checked));
  label.append(box, text);
  return label;
}

const grouped = (number) => number.toLocaleString('en-US').replaceAll(',', '\u202f');

function areaText(scene, area) {
  const digits = area >= 1000 ? 0 : area >= 10 ? 1 : 3;
  return `${grouped(Number(area.toFixed(digits)))}${scene.unit ? ' ' + shortUnit(scene) + '²' : ''}`;
}

const kColoringNames = {element: 'by element', height: 'by height', slope: 'by slope', deviation: 'by deviation', cut: 'by what the cutter leaves'};

export class Panel {
  constructor(scene, act) {
    this.scene = scene;
    this.act = act;
    this.selected = -1;
    this.fillHeader();
    this.fillElements();
    this.fillLooks();
    this.fillSection();
    this.fillPath();
    find('#measure').hidden = !scene.elements.length;
    find('#measure-on').addEventListener('click', () => act.measuring());
    find('#measure-clear').addEventListener('click', () => act.clearMeasure());
    for (const id of ['#fold', '#unfold']) find(id).addEventListener('click', () => this.toggle());
    find('#theme').addEventListener('click', () => act.theme());
  }

  toggle() {
    const panel = find('#panel');
    panel.hidden = !panel.hidden;
    find('#unfold').hidden = !panel.hidden;
    this.act.resized();
  }

  fillHeader() {
    const {scene} = this;
    document.title = `${scene.title} – diesink`;
    find('h1').textContent = scene.title;
    const sides = [0, 1, 2].map((k) => Number((scene.high[k] - scene.low[k]).toFixed(Math.min(3, scene.decimals))));
    const triangles = scene.elements.reduce((sum, each) => sum + each.triangles, 0);
    const facts = [sides.join(' × ') + (scene.unit ? ' ' + shortUnit(scene) : '')];
    if (triangles) facts.push(`${grouped(triangles)} triangles` + (scene.certified === undefined ? '' : `, at most ${Number(scene.certified.toPrecision(3))} off the surface`));
    if (!triangles && scene.path) facts.push(`${grouped(scene.pathPoints.length / 3)} points`);
    find('#facts').replaceChildren(...facts.flatMap((text, k) => (k ? [document.createElement('br'), text] : [text])));
    find('#facts').title = `${scene.maker}; coordinates in steps of ${scene.quantum}${scene.unit ? ' ' + shortUnit(scene) : ''}`;
  }

  fillElements() {
    const {scene, act} = this;
    find('#elements').hidden = !scene.elements.some((each) => each.name);
    this.rows = scene.elements.map((element, k) => {
      const row = document.createElement('li');
      const box = Object.assign(document.createElement('input'), {type: 'checkbox', checked: true});
      box.setAttribute('aria-label', `show ${element.name}`);
      const swatch = document.createElement('b');
      swatch.style.background = element.color;
      const name = document.createElement('span');
      name.textContent = element.name || '(no name)';
      if (element.type) {
        const type = document.createElement('small');
        type.textContent = (element.sign < 0 ? '− ' : '') + element.type;
        name.append(type);
      }
      const area = document.createElement('em');
      area.textContent = areaText(scene, element.area);
      row.append(box, swatch, name, area);
      row.title = `${element.name}: ${element.triangles} triangles` + (element.certified === undefined ? '' : `, off the surface by at most ${Number(element.certified.toPrecision(3))}`);
      box.addEventListener('click', (event) => event.stopPropagation());
      box.addEventListener('change', () => this.show(k, box.checked));
      row.addEventListener('click', () => act.select(this.selected === k ? -1 : k));
      row.addEventListener('dblclick', () => {
        for (let i = 0; i < this.rows.length; ++i) this.show(i, i === k);
      });
      row.addEventListener('pointerenter', () => act.near(k));
      row.addEventListener('pointerleave', () => act.near(-1));
      return row;
    });
    find('#elements ul').append(...this.rows);
    for (const button of document.querySelectorAll('[data-all]')) {
      button.addEventListener('click', () => {
        for (let k = 0; k < this.rows.length; ++k) this.show(k, button.dataset.all !== '');
      });
    }
  }

  show(k, shown) {
    this.rows[k].classList.toggle('off', !shown);
    this.rows[k].querySelector('input').checked = shown;
    this.act.show(k, shown);
  }

  // point: where it was picked, if it was.
  setSelected(k, point) {
    this.selected = k;
    for (const [i, row] of this.rows.entries()) row.classList.toggle('on', i === k);
    find('#picked').hidden = k < 0;
    if (k < 0) return;
    // Within the list alone: scrollIntoView would move the panel, too.
    const list = find('#elements ul'), row = this.rows[k];
    const top = row.offsetTop - list.offsetTop;
    if (top < list.scrollTop || top + row.offsetHeight > list.scrollTop + list.clientHeight) list.scrollTop = top - list.clientHeight / 2;
    const {scene} = this;
    const element = scene.elements[k];
    const rows = [[element.name || '(no name)', element.type ? (element.sign < 0 ? '− ' : '+ ') + element.type : '', 'main'], ['area', areaText(scene, element.area)]];
    if (element.certified !== undefined) rows.push(['deviation at most', lengthText(scene, element.certified)]);
    if (point) {
      rows.push(...['X', 'Y', 'Z'].map((name, i) => [name, lengthText(scene, point.point[i])]));
      if (point.deviation !== undefined) rows.push(['deviation here', lengthText(scene, point.deviation, scene.decimals + 1)]);
    }
    fillTable(find('#picked tbody'), rows);
  }

  fillLooks() {
    const {act, scene} = this;
    for (const button of document.querySelectorAll('#views button')) button.addEventListener('click', () => act.look(button.dataset.view));
    const names = act.colorings();
    const select = find('#coloring');
    select.append(...names.map((name) => new Option(kColoringNames[name], name)));
    select.parentElement.hidden = names.length === 0;
    select.addEventListener('change', () => act.color(select.value));
    const range = find('#range input');
    range.addEventListener('input', () => act.range(10 ** Number(range.value)));
    const shown = {crease: 'creases', edge: 'edges', jump: 'jumps', other: 'lines'};
    find('#lines').append(...act.lines().map((name) => checkbox(shown[name], true, (on) => act.line(name, on))));
    if (scene.elements.length === 0) find('#looks').querySelector('.checks').hidden = true;
  }

  // ends: texts under the scale's left, middle and right; `ranged`: the slider of its range shows.
  setLegend(name, ends, ranged) {
    find('#coloring').value = name;
    find('#legend').hidden = name === 'element';
    find('#range').hidden = !ranged;
    if (name === 'element') return;
    find('#legend canvas').getContext('2d').putImageData(new ImageData(new Uint8ClampedArray(scalePixels(name)), 256, 1), 0, 0);
    document.querySelectorAll('#legend .ends span').forEach((span, k) => { span.textContent = ends[k]; });
  }

  fillSection() {
    const {scene, act} = this;
    find('#cut').hidden = scene.elements.length === 0;
    const slider = find('#cut-place input[type=range]'), number = find('#cut-place input[type=number]');
    let axis = -1, side = 1;
    const own = scene.own([0, 0, 0]);
    const apply = (at) => {
      if (axis >= 0) number.value = (at + own[axis]).toFixed(Math.min(3, scene.decimals));
      act.section(axis, at, side);
    };
    const fromSlider = () => (axis < 0 ? 0 : scene.low[axis] + Number(slider.value) * (scene.high[axis] - scene.low[axis]));
    for (const button of document.querySelectorAll('#cut-axis button')) {
      button.addEventListener('click', () => {
        if (button.dataset.flip) {
          side = -side;
        } else {
          axis = button.dataset.axis === '' ? -1 : Number(button.dataset.axis);
          // What hides the cut from the usual view goes.
          side = axis === 1 ? -1 : 1;
          slider.value = 0.5;
          for (const each of document.querySelectorAll('#cut-axis [data-axis]')) each.classList.toggle('on', each === button);
        }
        find('#cut-place').hidden = axis < 0;
        apply(fromSlider());
      });
    }
    slider.addEventListener('input', () => apply(fromSlider()));
    number.addEventListener('change', () => {
      const at = Number(number.value) - own[axis];
      slider.value = (at - scene.low[axis]) / (scene.high[axis] - scene.low[axis]);
      act.section(axis, at, side);
    });
    number.step = 'any';
  }

  fillPath() {
    const {scene, act} = this;
    find('#path').hidden = !scene.path;
    if (!scene.path) return;
    const slider = find('#path-place');
    slider.addEventListener('input', () => act.along(Number(slider.value)));
    find('#path-back').addEventListener('click', () => act.step(-1));
    find('#path-on').addEventListener('click', () => act.step(1));
    find('#path-play').addEventListener('click', () => act.play());
    find('#path-shown').append(checkbox('path', scene.coloring !== 'cut', (on) => act.showPath('path', on)), checkbox('what is ahead', true, (on) => act.showPath('rest', on)),
      ...(scene.cutter ? [checkbox('cutter', true, (on) => act.showPath('cutter', on))] : []));
  }

  get speed() { return Number(find('#path-speed').value); }

  setPath(path, playing) {
    const {scene} = this;
    find('#path-place').value = path.place;
    find('#path-play').textContent = playing ? 'Pause' : 'Play';
    find('#path-play').classList.toggle('on', Boolean(playing));
    const own = scene.own([0, 0, 0]);
    const rows = [['point', `${grouped(path.at + 1)} of ${grouped(path.count)}`],
      ['tip', path.tip.map((v, k) => (v + own[k]).toFixed(Math.min(3, scene.decimals))).join('  ')],
      ['move', path.rapid ? 'rapid' : scene.path.feed > 0 ? `feed ${Number(scene.path.feed.toPrecision(6))} ${shortUnit(scene)}/min` : 'feed'],
      ['length', `${(path.place * path.total).toFixed(1)} of ${path.total.toFixed(1)} ${shortUnit(scene)}`]];
    if (scene.cutter) {
      rows.push(['cutter', `Ø ${Number(scene.cutter.diameter.toPrecision(6))}, corner ${Number(scene.cutter.corner_radius.toPrecision(6))}`]);
    }
    fillTable(find('#path tbody'), rows);
  }
}
