"use strict";
// Figures, model and doubts as tables.

function figureTable(rows) {
  const errors = rows.some((row) => row.error), intervals = rows.some((row) => row.interval);
  const head = make("tr", {}, make("th", {}, "figure"), make("th", { class: "number" }, "value"), make("th", {}, "unit"));
  if (errors) head.append(make("th", { class: "number" }, "error"));
  if (intervals) head.append(make("th", { class: "number" }, "95 % interval"));
  const body = make("tbody");
  for (const row of rows) {
    const words = make("td", {}, make("div", { class: "words" }, row.words));
    if (row.meaning) words.append(make("div", { class: "meaning" }, row.meaning));
    const sort = row.value.length > 24 ? "number long" : "number";
    const line = make("tr", {}, words, make("td", { class: sort }, row.value), make("td", { class: "unit" }, row.unit));
    if (errors) line.append(make("td", { class: "number" }, row.error ? `± ${row.error}` : ""));
    if (intervals) line.append(make("td", { class: "number" }, row.interval));
    body.append(line);
  }
  return make("div", { class: "scroll" }, make("table", { class: "figures" }, make("thead", {}, head), body));
}

function ballTable(table, noun) {
  const head = make("tr", {}, make("th", {}, noun));
  for (const [words, unit, meaning] of table.header) {
    head.append(make("th", { class: "number", title: meaning }, words, make("div", { class: "unit" }, unit || " ")));
  }
  const body = make("tbody");
  table.rows.forEach((row, k) => {
    body.append(make("tr", {}, make("td", {}, String(k)), ...row.map((one) => make("td", { class: "number" }, one))));
  });
  if (table.errors.length) {
    body.append(make("tr", {}, make("td", {}, "±"), ...table.errors.map((one) => make("td", { class: "number" }, one))));
  }
  const shown = make("div", { class: "scroll" }, make("table", { class: "balls" }, make("thead", {}, head), body));
  return table.title ? make("section", {}, make("p", { class: "note" }, table.title), shown) : shown;
}

function factList(facts) {
  const list = make("dl");
  for (const [words, text] of facts) list.append(make("dt", {}, words), make("dd", {}, text));
  return list;
}

function sentences(title, texts, sort) {
  const list = make("ul", {}, ...texts.map((text) => make("li", {}, text)));
  return texts.length ? make("section", { class: `said ${sort}` }, make("h3", {}, title), list) : "";
}

// Shares of a variance as bars with intervals: rows of {words, first, total} with value, low, high.
function shareBars(found) {
  const box = make("section", { class: "chart" }, make("header", {}, make("h3", {}, found.title)));
  const names = make("div", { class: "names" });
  found.orders.forEach((order, k) => names.append(make("span", { class: "name" }, make("i", { class: `order${k}` }), order)));
  box.append(names);
  for (const row of found.rows) {
    const bars = make("div", { class: "bars" });
    row.shares.forEach(({ value, low, high }, k) => {
      const percent = (one) => `${100.0 * Math.min(Math.max(one, 0.0), 1.0)}%`;
      const bar = make("div", { class: "share" }, make("div", { class: `bar order${k}`, style: `width: ${percent(value)}` }));
      if (low !== null && high !== null) {
        bar.append(make("div", { class: "whisker", style: `left: ${percent(low)}; right: calc(100% - ${percent(high)})` }));
      }
      bars.append(make("div", { class: "lane" }, bar, make("span", { class: "number" }, `${(Math.round(1000.0 * value) / 10.0 || 0.0).toFixed(1)} %`)));
    });
    box.append(make("div", { class: "row" }, make("div", { class: "words" }, row.words), bars));
  }
  return box;
}
