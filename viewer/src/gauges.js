// The axes and the scale bar in the corner.
// SPDX-License-Identifier: Apache-2.0
import {shortUnit} from './scene.js';

const kColors = ['#d64545', '#2f9e44', '#2f6fd6'];

export function drawAxes(svg, eye) {
  const parts = ['X', 'Y', 'Z'].map((name, k) => {
    const x = 34 * eye.right.getComponent(k), y = -34 * eye.up.getComponent(k), toward = eye.toward.getComponent(k);
    const ends = Math.hypot(x, y) < 4;  // seen end on
    return {toward, text: `<line x1="0" y1="0" x2="${x}" y2="${y}" stroke="${kColors[k]}" stroke-width="3" stroke-linecap="round"/>` +
      (ends ? '' : `<text x="${x * 1.34}" y="${y * 1.34}" fill="${kColors[k]}">${name}</text>`)};
  });
  parts.sort((a, b) => a.toward - b.toward);
  svg.innerHTML = parts.map((part) => part.text).join('');
}

// A length of 1, 2 or 5 times a power of ten.
export function drawScale(box, eye, scene) {
  const most = 140 * eye.unitsPerPixel;
  const decade = 10 ** Math.floor(Math.log10(most));
  const length = [5, 2, 1].map((each) => each * decade).find((each) => each <= most * (1 + 1e-9)) ?? decade;
  box.querySelector('i').style.width = `${length / eye.unitsPerPixel}px`;
  box.querySelector('span').textContent = `${Number(length.toPrecision(1))} ${shortUnit(scene)}`.trim();
}
