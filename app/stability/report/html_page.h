#pragma once

namespace tandem {

/// The style and the script of all reports.
inline constexpr const char* kPageStyle = R"css(
:root { color-scheme: light; }
body { font: 15px/1.5 "DejaVu Sans", Verdana, Arial, sans-serif; color: #202020;
       background: #ffffff; margin: 0 auto; padding: 1.5em 2em 4em; max-width: 1120px; }
h1 { font-size: 1.5em; margin: 0 0 .3em; } h2 { font-size: 1.2em; margin: 2em 0 .5em;
     border-bottom: 1px solid #c8c8c8; } h3 { font-size: 1em; margin: 1.4em 0 .3em; }
p, figcaption { max-width: 62em; } figcaption { color: #505050; font-size: .9em; }
figure { margin: 1em 0 1.6em; } svg { max-width: 100%; height: auto; }
code { background: #f1f1f1; padding: .1em .3em; font-size: .92em; overflow-wrap: anywhere; }
dl { display: grid; grid-template-columns: max-content 1fr; gap: .15em 1em; margin: .8em 0; }
dt { color: #505050; } dd { margin: 0; }
.wide { overflow: auto; max-height: 42em; border: 1px solid #d8d8d8; }
table { border-collapse: collapse; font-size: .87em; font-variant-numeric: tabular-nums; }
th, td { padding: .2em .6em; text-align: left; white-space: nowrap;
         border-bottom: 1px solid #e6e6e6; }
th { background: #f4f4f4; position: sticky; top: 0; } td.n, th.n { text-align: right; }
.script th { cursor: pointer; }
tr:target td, tr.found td { background: #fff3b8; }
.pass { color: #00603c; } .fail { color: #a02800; font-weight: bold; }
.verdict { display: inline-block; padding: .15em .7em; border: 2px solid; border-radius: .3em;
           font-weight: bold; }
#told { position: fixed; left: 0; right: 0; bottom: 0; padding: .4em 2em; background: #202020;
        color: #ffffff; font-size: .9em; display: none; }
)css";

inline constexpr const char* kPageScript = R"js(
'use strict';
document.body.classList.add('script');
for (const head of document.querySelectorAll('th')) {
  head.addEventListener('click', () => {
    const column = Array.from(head.parentNode.children).indexOf(head);
    const body = head.closest('table').tBodies[0];
    const falling = head.dataset.order === 'rising';
    head.dataset.order = falling ? 'falling' : 'rising';
    const value = (row) => row.children[column].textContent;
    const order = (a, b) => {
      const x = parseFloat(value(a)), y = parseFloat(value(b));
      if (isNaN(x) || isNaN(y)) {
        return isNaN(x) && isNaN(y) ? value(a).localeCompare(value(b)) : isNaN(x) - isNaN(y);
      }
      return x - y;
    };
    const rows = Array.from(body.rows).sort(order);
    if (falling) rows.reverse();
    body.append(...rows);
  });
}
const told = document.getElementById('told');
const shapeAt = (event) => event.target.closest('rect, circle, path');
const hintOf = (shape) => shape && shape.querySelector('title');
for (const figure of document.querySelectorAll('figure')) {
  figure.addEventListener('mouseover', (event) => {
    const hint = hintOf(shapeAt(event));
    told.textContent = hint ? hint.textContent + ' (click: its line in the table)' : '';
    told.style.display = hint ? 'block' : 'none';
  });
  figure.addEventListener('mouseleave', () => { told.style.display = 'none'; });
  figure.addEventListener('click', (event) => {
    const hint = hintOf(shapeAt(event));
    const cell = hint && /^cell (\d+):/.exec(hint.textContent);
    const row = cell && document.getElementById(figure.dataset.sweep + '-' + cell[1]);
    if (!row) return;
    for (const old of document.querySelectorAll('tr.found')) old.classList.remove('found');
    row.classList.add('found');
    row.scrollIntoView({block: 'center'});
  });
}
)js";

}  // namespace tandem
