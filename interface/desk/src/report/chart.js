/* Zoom, cross-hair and legend of the line charts. A chart's lines and markers stand in the page
   as they are drawn without this script; `data-x` and `data-y` are the ends of its axes. */
'use strict';
(() => {
const LEAST_DRAG = 8, REACH = 6;
const tip = document.createElement('div');
tip.id = 'values';
tip.hidden = true;
document.body.append(tip);
const set = (element, attributes) => {
  for (const name in attributes) element.setAttribute(name, attributes[name]);
};
const clamp = (value, high) => Math.min(Math.max(value, 0), high);
/* As the labels of the page: a true minus sign, powers of ten in superscript. */
const typeset = text => text.replace(/^-(?=[0.]*$)/, '').replace('-', '−')
  .replace(/e\+?([-−]?\d+)/, (_, power) => '·10' + [...power].map(c => '⁰¹²³⁴⁵⁶⁷⁸⁹'[c] ?? '⁻').join(''));
const decimals = step => clamp(-Math.floor(Math.log10(step) + 1e-9), 20);

class Axis {
  constructor(text, length) {
    this.log = text.startsWith('log');
    [this.low, this.high] = text.replace('log ', '').split(' ').map(Number);
    this.length = length;
    this.reset();
  }
  /* The window: a part of the length, in pixels of the drawing as it came. */
  reset() { this.window(0, this.length); }
  window(from, to) { [this.from, this.to] = [from, to]; }
  /* From a pixel of the drawing to one on the screen's window, and back. */
  show(at) { return (at - this.from) / (this.to - this.from) * this.length; }
  drawn(at) { return this.from + at / this.length * (this.to - this.from); }
  coordinate(drawn) { return this.low + (this.high - this.low) * drawn / this.length; }
  place(coordinate) { return this.show((coordinate - this.low) / (this.high - this.low) * this.length); }
  read(drawn) {
    const at = this.coordinate(drawn);
    return typeset(this.log ? String(+(10 ** at).toPrecision(3))
      : at.toFixed(decimals((this.high - this.low) / this.length)));
  }
  /* Places and labels: steps of 1, 2 or 5; on a logarithmic axis that shows decades, theirs. */
  ticks(about) {
    const [low, high] = [this.from, this.to].map(at => this.coordinate(at)).sort((a, b) => a - b);
    const ticks = [], span = high - low;
    if (this.log && span > 1) {
      const stride = Math.ceil(span / about);
      for (let decade = Math.floor(low); decade <= high; decade++)
        for (const factor of span < 2 ? [1, 2, 5] : [1])
          if (decade % stride === 0) ticks.push([decade + Math.log10(factor), typeset(String(+(factor * 10 ** decade).toPrecision(6)))]);
    } else {
      const value = at => this.log ? 10 ** at : at;
      const raw = (value(high) - value(low)) / about, power = 10 ** Math.floor(Math.log10(raw));
      const step = power * [1, 2, 5, 10].find(factor => factor * power >= raw * (1 - 1e-9));
      for (let n = Math.ceil(value(low) / step); n * step <= value(high); n++)
        ticks.push([this.log ? Math.log10(n * step) : n * step,
          typeset(this.log ? String(+(n * step).toPrecision(6)) : (n * step).toFixed(decimals(step)))]);
    }
    return ticks.filter(([at]) => at >= low && at <= high).map(([at, label]) => [this.place(at).toFixed(1), label]);
  }
}
/* The ordinate counts from the bottom, pixels from the top. */
class Ordinate extends Axis {
  coordinate(drawn) { return super.coordinate(this.length - drawn); }
  place(coordinate) { return this.show((this.high - coordinate) / (this.high - this.low) * this.length); }
}
/* Pairs of absolute coordinates: all of a polyline, of markers those after each M. */
const PAIRS = /(^|[ M])(-?[\d.]+),(-?[\d.]+)/g;

function enliven(svg, plot) {
  const width = +plot.getAttribute('width'), height = +plot.getAttribute('height');
  const x = new Axis(plot.dataset.x, width), y = new Ordinate(plot.dataset.y, height);
  const axes = svg.querySelector('.axes'), unzoomed = axes.innerHTML, cut = plot.classList.contains('cut');
  const shapes = [...plot.querySelectorAll('polyline,path')].map(element => {
    const name = element.tagName === 'path' ? 'd' : 'points', text = element.getAttribute(name);
    return { element, name, text, points: [...text.matchAll(PAIRS)].map(pair => [+pair[2], +pair[3]]) };
  });
  const labels = [...svg.querySelectorAll('.lt,.mt')].map(element =>
    ({ element, x: +element.getAttribute('x'), y: +element.getAttribute('y'), limit: element.matches('.lt') }));
  const group = plot.parentNode;
  group.insertAdjacentHTML('beforeend',
    `<path class="cross"/><rect class="pick"/><rect class="hit" width="${width}" height="${height}"/>`);
  const [cross, pick, hit] = [...group.children].slice(-3);
  /* The title would come up as a hint over the values. */
  const title = svg.querySelector('title');
  set(svg, { role: 'group', 'aria-label': title.textContent });
  title.remove();

  const draw = () => {
    const zoomed = x.to - x.from < width || y.to - y.from < height;
    plot.classList.toggle('cut', cut || zoomed);
    for (const { element, name, text } of shapes)
      element.setAttribute(name, zoomed ? text.replace(PAIRS, (_, before, px, py) =>
        `${before}${x.show(+px).toFixed(1)},${y.show(+py).toFixed(1)}`) : text);
    for (const label of labels) {
      const at = label.limit ? y.show(label.y) : x.show(label.x);
      label.element.setAttribute(label.limit ? 'y' : 'x', at);
      label.element.style.display = at < -1 || at > (label.limit ? height : width) + 1 ? 'none' : '';
    }
    if (!zoomed) { axes.innerHTML = unzoomed; return; }
    const across = x.ticks(width / 90), up = y.ticks(height / 50);
    axes.innerHTML = `<path class="gr" d="${across.map(([at]) => `M${at},0V${height}`).join('')}${up.map(([at]) => `M0,${at}H${width}`).join('')}"/>`
      + `<path class="ax" d="M0,0V${height}H${width}${across.map(([at]) => `M${at},${height}v4`).join('')}${up.map(([at]) => `M0,${at}h-4`).join('')}"/>`
      + `<g class="tt" text-anchor="middle">${across.map(([at, label]) => `<text x="${at}" y="${height + 17}">${label}</text>`).join('')}</g>`
      + `<g class="tt" text-anchor="end">${up.map(([at, label]) => `<text x="-8" y="${at}" dy="4">${label}</text>`).join('')}</g>`;
  };
  const at = event => {
    const point = new DOMPoint(event.clientX, event.clientY).matrixTransform(hit.getScreenCTM().inverse());
    return [clamp(point.x, width), clamp(point.y, height)];
  };
  const all = [...plot.querySelectorAll('.series')];
  /* Where a series passes the pointer's abscissa, nearest to the pointer. */
  const passes = (series, px, py) => {
    let nearest = null;
    const offer = y => { if (nearest === null || Math.abs(y - py) < Math.abs(nearest - py)) nearest = y; };
    for (const { element, name, points } of shapes.filter(shape => shape.element.parentNode === series))
      points.forEach(([x1, y1], n) => {
        if (name === 'd') { if (Math.abs(x.show(x1) - x.show(px)) <= REACH) offer(y1); return; }
        const [x0, y0] = points[n - 1] ?? [x1, y1];
        if (Math.min(x0, x1) <= px && px <= Math.max(x0, x1)) offer(x0 === x1 ? y1 : y0 + (y1 - y0) * (px - x0) / (x1 - x0));
      });
    return nearest;
  };
  const line = (text, colour) => {
    const row = document.createElement('div'), content = document.createElement('span');
    row.style.borderColor = colour;
    content.textContent = text;
    row.append(content);
    return row;
  };
  const tell = event => {
    const [sx, sy] = at(event), px = x.drawn(sx), py = y.drawn(sy);
    set(cross, { d: `M${sx},0V${height}M0,${sy}H${width}` });
    const rows = all.filter(series => !series.classList.contains('off')).flatMap(series => {
      const value = passes(series, px, py);
      return value === null ? [] : [line(`${series.dataset.name}: ${y.read(value)}`, getComputedStyle(series.firstElementChild).stroke)];
    });
    tip.replaceChildren(line(`${x.read(px)} | ${y.read(py)}`, 'transparent'), ...rows);
    tip.hidden = false;
    const left = event.clientX + 14;
    tip.style.left = `${left + tip.offsetWidth > innerWidth ? left - 28 - tip.offsetWidth : left}px`;
    tip.style.top = `${clamp(event.clientY + 14, innerHeight - tip.offsetHeight)}px`;
  };
  let start = null;
  /* What is dragged over; a drag along one axis zooms that axis only. */
  const dragged = event => {
    const end = at(event);
    const spans = [0, 1].map(n => [Math.min(start[n], end[n]), Math.max(start[n], end[n])]);
    const wide = spans.map(([from, to]) => to - from >= LEAST_DRAG);
    return wide.some(Boolean) && spans.map((span, n) => wide[n] ? span : [0, [width, height][n]]);
  };
  const mark = box => set(pick, box ? { x: box[0][0], y: box[1][0], width: box[0][1] - box[0][0], height: box[1][1] - box[1][0] } : { width: 0 });
  hit.addEventListener('pointerdown', event => {
    if (event.button !== 0 || event.pointerType === 'touch') return;
    start = at(event);
    hit.setPointerCapture(event.pointerId);
  });
  hit.addEventListener('pointermove', event => {
    tell(event);
    if (start) mark(dragged(event));
  });
  hit.addEventListener('pointerup', event => {
    const box = start && dragged(event);
    start = null;
    mark(null);
    if (!box) return;
    for (const [n, axis] of [x, y].entries()) {
      const [from, to] = box[n].map(at => axis.drawn(at));
      if (to - from >= 1) axis.window(from, to);
    }
    draw();
  });
  hit.addEventListener('pointercancel', () => { start = null; mark(null); });
  hit.addEventListener('pointerleave', () => { tip.hidden = true; set(cross, { d: '' }); });
  hit.addEventListener('dblclick', () => { x.reset(); y.reset(); draw(); });

  for (const key of svg.querySelectorAll('.key')) {
    set(key, { role: 'button', tabindex: 0, 'aria-pressed': true });
    const turn = () => {
      const off = key.classList.toggle('off');
      all[key.dataset.series].classList.toggle('off', off);
      key.setAttribute('aria-pressed', !off);
    };
    key.addEventListener('click', turn);
    key.addEventListener('keydown', event => {
      if (event.key === 'Enter' || event.key === ' ') { event.preventDefault(); turn(); }
    });
  }
}

const plots = document.querySelectorAll('svg.chart .plot');
for (const plot of plots) enliven(plot.ownerSVGElement, plot);
if (plots.length) document.querySelector('footer').append(' In a chart, drag to zoom and double-click to see all again; click an entry of its legend to hide or show the series.');
})();
