// SPDX-License-Identifier: Apache-2.0
// The script of the report's pixel section: reads the values beside it, draws the spectrum of the pixel that
// was clicked or reached with the arrow keys.
#include "fit/report_parts.h"

namespace dermap {

std::string_view PixelScript() {
  return R"js(
(() => {
  const info = JSON.parse(document.getElementById("pixel-info").textContent);
  const packed = atob(document.getElementById("pixel-values").textContent);
  const count = info.width * info.height, missing = 65535;
  const value = (plane, at) => {
    const byte = 2 * (plane * count + at);
    const code = packed.charCodeAt(byte) + 256 * packed.charCodeAt(byte + 1);
    const [low, high] = info.ranges[plane];
    return code === missing ? NaN : low + (high - low) * code / (missing - 1);
  };
  const stage = document.getElementById("pixel-stage"), mark = document.getElementById("pixel-mark");
  const chart = document.getElementById("pixel-chart"), said = document.getElementById("pixel-said");
  const rows = document.getElementById("pixel-rows");
  const bands = info.bands.length;
  const number = (v) => Number(v.toPrecision(3)).toString();

  function draw(at) {
    const left = 60, right = 545, top = 12, bottom = 285;
    const first = info.bands[0], last = info.bands[bands - 1], margin = 0.05 * (last - first) || 10;
    const spectrum = info.bands.map((nm, b) => ({
      nm, measured: value(3 * b, at), noise: value(3 * b + 1, at), predicted: value(3 * b + 2, at) }));
    const peak = Math.max(...spectrum.map((s) => Math.max(s.measured + s.noise || 0, s.predicted || 0)));
    const step = [0.01, 0.02, 0.05, 0.1, 0.2, 0.5].find((s) => peak / s <= 6) || 1;
    const end = step * Math.ceil((peak + 1e-9) / step);
    const x = (nm) => left + (right - left) * (nm - first + margin) / (last - first + 2 * margin);
    const y = (r) => bottom - (bottom - top) * Math.max(r, 0) / end;
    let svg = "";
    for (let k = 0; k * step <= end + 1e-9; ++k)
      svg += `<line class="grid" x1="${left}" x2="${right}" y1="${y(k * step)}" y2="${y(k * step)}"/>` +
        `<text class="end" x="${left - 6}" y="${y(k * step) + 4}">${number(100 * k * step)} %</text>`;
    let before = -1e9;
    for (const s of spectrum) {
      if (x(s.nm) - before >= 34) svg += `<text class="mid" x="${before = x(s.nm)}" y="${bottom + 17}">${number(s.nm)}</text>`;
    }
    svg += `<text class="mid label" x="${(left + right) / 2}" y="${bottom + 36}">wavelength, nm</text>`;
    const known = spectrum.filter((s) => !isNaN(s.predicted));
    svg += `<path class="curve s1" d="${known.map((s, i) => (i ? "L" : "M") + x(s.nm) + " " + y(s.predicted)).join("")}"/>`;
    for (const s of spectrum) {
      if (isNaN(s.measured)) continue;
      const low = y(s.measured - s.noise), high = y(s.measured + s.noise), at_x = x(s.nm);
      if (!isNaN(s.noise))
        svg += `<path class="whisker s0" d="M${at_x} ${low}V${high}M${at_x - 4} ${low}h8M${at_x - 4} ${high}h8"/>`;
      svg += `<circle class="dot s0" cx="${at_x}" cy="${y(s.measured)}" r="3.6"/>`;
    }
    chart.innerHTML = svg;
    const known_data = spectrum.filter((s) => !isNaN(s.measured) && s.noise > 0);
    const off = known_data.map((s) => Math.abs(s.measured - s.predicted) / s.noise);
    return off.length ? Math.sqrt(off.reduce((sum, o) => sum + o * o, 0) / off.length) : NaN;
  }

  function tell(at, column, row, misfit) {
    rows.replaceChildren(...info.maps.map((map, m) => {
      const plane = 3 * bands + 2 * m, line = document.createElement("tr"), sigma = value(plane + 1, at);
      const cells = [map.name, map.description, number(value(plane, at)),
                     map.free && sigma > 0 ? "\u00b1 " + number(sigma) : "held", map.unit];
      line.append(...cells.map((text) => Object.assign(document.createElement("td"), { textContent: text })));
      return line;
    }));
    const flags = info.flags.filter((f, bit) => value(3 * bands + 2 * info.maps.length, at) & (1 << bit));
    said.textContent = `Pixel ${column * info.step}, ${row * info.step} (column, row). ` +
      (isNaN(misfit) ? "Nothing was measured here: the values are its neighbours'. "
       : misfit < 2.2 ? `The prediction is ${Number(misfit.toPrecision(2))} error bars off on average: as good as the measurement allows. `
       : `The prediction is ${Number(misfit.toPrecision(2))} error bars off on average: do not trust this pixel's values. `) +
      (flags.length ? "Flagged: " + flags.join(", ") + "." : "No flags.");
  }

  let column = info.start[0], row = info.start[1];
  function choose(c, r) {
    column = Math.min(Math.max(Math.round(c), 0), info.width - 1);
    row = Math.min(Math.max(Math.round(r), 0), info.height - 1);
    mark.style.left = 100 * (column + 0.5) / info.width + "%";
    mark.style.top = 100 * (row + 0.5) / info.height + "%";
    const at = row * info.width + column;
    tell(at, column, row, draw(at));
  }
  function click(event, picture) {
    const box = picture.getBoundingClientRect();
    choose(Math.floor(info.width * (event.clientX - box.left) / box.width),
           Math.floor(info.height * (event.clientY - box.top) / box.height));
  }
  stage.addEventListener("click", (event) => click(event, stage.querySelector("img")));
  stage.addEventListener("keydown", (event) => {
    const far = event.shiftKey ? 10 : 1;
    const [dx, dy] = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] }[event.key] || [0, 0];
    if (!dx && !dy) return;
    event.preventDefault();
    choose(column + dx * far, row + dy * far);
  });
  for (const picture of document.querySelectorAll("#maps img.pixels")) {
    picture.style.cursor = "crosshair";
    picture.addEventListener("click", (event) => {
      click(event, picture);
      document.getElementById("pixel").scrollIntoView();
    });
  }
  choose(column, row);
})();
)js";
}

}  // namespace dermap
