// Small drawings on canvases: lines over axes, and the array as a picture. Colours are those of the style sheet.
const css = (name) => getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();

// Ten equidistant colours of cividis (Nunez et al. 2018), as in the reports: legible with any colour vision.
const cividis = [[0, 32, 77], [0, 51, 111], [57, 72, 107], [87, 92, 109], [112, 113, 115], [138, 135, 121], [166, 157, 117],
  [196, 181, 108], [228, 207, 91], [255, 234, 70]];

export function colourOf(share) {
  const at = Math.min(Math.max(share, 0), 1) * (cividis.length - 1);
  const low = Math.min(Math.floor(at), cividis.length - 2);
  return cividis[low].map((value, i) => Math.round(value + (cividis[low + 1][i] - value) * (at - low)));
}
const rgb = (share) => `rgb(${colourOf(share).join(' ')})`;

// The canvas's context in CSS pixels, as large as it is shown; null while it is not shown.
function context(canvas) {
  const { width, height } = canvas.getBoundingClientRect();
  if (width < 8 || height < 8) return null;
  const dots = window.devicePixelRatio || 1;
  if (canvas.width !== Math.round(width * dots) || canvas.height !== Math.round(height * dots)) {
    canvas.width = Math.round(width * dots);
    canvas.height = Math.round(height * dots);
  }
  const c = canvas.getContext('2d');
  c.setTransform(dots, 0, 0, dots, 0, 0);
  c.clearRect(0, 0, width, height);
  c.font = '12px system-ui, "DejaVu Sans", Arial, sans-serif';
  return { c, width, height };
}

function ticks(low, high, wanted) {
  const raw = (high - low) / wanted;
  const power = 10 ** Math.floor(Math.log10(raw));
  const step = [1, 2, 5, 10].map((n) => n * power).find((n) => n >= raw);
  const out = [];
  for (let t = Math.ceil(low / step - 1e-9) * step; t <= high + 1e-9 * step; t += step) out.push(t);
  return out;
}

export const clock = (seconds) => {
  const s = Math.max(0, Math.round(seconds));
  return `${Math.floor(s / 3600)}:${String(Math.floor(s / 60) % 60).padStart(2, '0')}:${String(s % 60).padStart(2, '0')}`;
};

const timeTicks = [1, 2, 5, 10, 20, 30, 60, 120, 300, 600, 1200, 1800, 3600, 7200, 14400];

// series: {x, y, colour, width, dash, dot}. x and y: {low, high, label, time}; without its label the x axis is another chart's.
export function lines(canvas, { x, y, series, empty }) {
  const drawn = context(canvas);
  if (!drawn) return;
  const { c, width, height } = drawn;
  const left = 44, right = 10, top = 8, bottom = x.label ? 34 : 6;
  const w = width - left - right, h = height - top - bottom;
  const px = (v) => left + (w * (v - x.low)) / (x.high - x.low);
  const py = (v) => top + h - (h * (v - y.low)) / (y.high - y.low);
  c.strokeStyle = css('line');
  c.fillStyle = css('muted');
  c.lineWidth = 1;
  c.textBaseline = 'middle';
  c.textAlign = 'right';
  for (const t of ticks(y.low, y.high, Math.max(4, Math.floor(h / 30)))) {
    c.beginPath();
    c.moveTo(left, Math.round(py(t)) + 0.5);
    c.lineTo(left + w, Math.round(py(t)) + 0.5);
    c.stroke();
    c.fillText(String(+t.toPrecision(4)), left - 6, py(t));
  }
  c.textAlign = 'center';
  c.textBaseline = 'top';
  let across = ticks(x.low, x.high, Math.max(2, Math.floor(w / 90)));
  if (x.time) {
    const step = timeTicks.find((s) => (x.high - x.low) / s <= w / 70) || 28800;
    across = [];
    for (let t = Math.ceil(x.low / step) * step; t <= x.high; t += step) across.push(t);
  }
  for (const t of x.label ? across : []) {
    const label = x.time ? clock(t) : String(+t.toPrecision(4));
    const half = c.measureText(label).width / 2;
    c.fillText(label, Math.min(Math.max(px(t), left + half), left + w - half), top + h + 5);
  }
  if (x.label) c.fillText(x.label, left + w / 2, height - 13);
  c.save();
  c.translate(9, top + h / 2);
  c.rotate(-Math.PI / 2);
  c.fillText(y.label, 0, -6);
  c.restore();
  c.save();
  c.beginPath();
  c.rect(left, top - 2, w + 2, h + 4);
  c.clip();
  for (const one of series) {
    c.strokeStyle = c.fillStyle = css(one.colour);
    c.lineWidth = one.width || 2;
    c.lineJoin = 'round';
    c.setLineDash(one.dash || []);
    c.beginPath();
    let pen = false;
    for (let i = 0; i < one.x.length; i += 1) {
      if (one.x[i] == null || one.y[i] == null) { pen = false; continue; }
      if (pen) c.lineTo(px(one.x[i]), py(one.y[i]));
      else c.moveTo(px(one.x[i]), py(one.y[i]));
      pen = true;
    }
    c.stroke();
    c.setLineDash([]);
    const last = one.x.length - 1;
    if (one.dot && last >= 0) {
      c.beginPath();
      c.arc(px(one.x[last]), py(one.y[last]), 4.5, 0, 7);
      c.fill();
    }
  }
  c.restore();
  if (empty && series.every((one) => one.x.length === 0)) {
    c.fillStyle = css('muted');
    c.textAlign = 'center';
    c.textBaseline = 'middle';
    c.fillText(empty, left + w / 2, top + h / 2);
  }
}

function hatch(c, x, y, w, h, both) {
  c.save();
  c.beginPath();
  c.rect(x, y, w, h);
  c.clip();
  for (const [colour, wide] of [['#ffffff', 3], ['#aa1111', 1.6]]) {
    c.strokeStyle = colour;
    c.lineWidth = wide;
    c.beginPath();
    for (let d = -h; d < w; d += 6) {
      c.moveTo(x + d, y + h);
      c.lineTo(x + d + h, y);
      if (!both) continue;
      c.moveTo(x + d, y);
      c.lineTo(x + d + h, y + h);
    }
    c.stroke();
  }
  c.restore();
}

// values: row-major; top: of the scale. dead taxels are hatched both ways, saturated ones one way.
export function map(canvas, { rows, columns, values, top, dead, saturated, chosen }) {
  const drawn = context(canvas);
  if (!drawn) return;
  const { c, width, height } = drawn;
  const w = width / columns, h = height / rows;
  const place = (taxel) => [(taxel % columns) * w, Math.floor(taxel / columns) * h];
  for (let i = 0; i < values.length; i += 1) {
    const [x, y] = place(i);
    c.fillStyle = rgb(values[i] / top);
    c.fillRect(x, y, w + 0.6, h + 0.6);
  }
  for (const taxel of dead) hatch(c, ...place(taxel), w, h, true);
  for (const taxel of saturated) hatch(c, ...place(taxel), w, h, false);
  if (chosen < 0 || chosen >= values.length) return;
  const [x, y] = place(chosen);
  for (const [colour, wide] of [['#000000', 5], ['#ffffff', 2.5]]) {
    c.strokeStyle = colour;
    c.lineWidth = wide;
    c.strokeRect(x + 1, y + 1, w - 2, h - 2);
  }
}

export function colourBar(canvas, { top, unit, digits }) {
  const drawn = context(canvas);
  if (!drawn) return;
  const { c, height } = drawn;
  for (let y = 0; y < height; y += 1) {
    c.fillStyle = rgb(1 - y / height);
    c.fillRect(0, y, 18, 1.5);
  }
  c.fillStyle = css('ink');
  c.textBaseline = 'middle';
  const steps = 5;
  for (let i = 0; i <= steps; i += 1) {
    const y = Math.min(Math.max(height * (1 - i / steps), 7), height - 7);
    c.fillText(`${((top * i) / steps).toFixed(digits)} ${unit}`, 24, y);
  }
}
