"use strict";
// A study: distributions with quantiles, shares of the variance, convergence, bands of histories.

function showStudy(found, panes, charts) {
  document.body.classList.add("flat", "still");
  const curves = panes.add("Results", "curves");
  for (const one of found.charts) charts.push(new Chart(curves, studySpec(one, found.palette)));
  for (const one of found.shares) curves.append(shareBars(one));
  const figures = panes.add("Statistics");
  for (const table of found.statistics) figures.append(make("section", { class: "card" }, make("h3", {}, table.title)), figureTable(table.rows));
  showModel(panes.add("Study"), found, "");
}

function studySpec(one, palette) {
  const lines = one.lines.map((line) => ({
    ...line, number: line.colour, colour: curveColour(line.colour, palette), dash: line.dashed ? [7, 4] : [],
    fill: line.filled ? `${palette[line.colour]}44` : undefined, stroke: palette[line.colour],
  }));
  const spans = one.spans.map((span) => ({ ...span, colour: palette[span.colour] }));
  const bands = one.bands.map(([high, low, colour]) => ({ series: [high + 1, low + 1], fill: `${palette[colour]}33` }));
  return { ...one, lines, spans, bands, height: 250, named: true, range: one.from_zero ? (u, low, high) => [0.0, 1.08 * high || 1.0] : undefined };
}
