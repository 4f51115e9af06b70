"use strict";
// Tables: a click on a heading sorts by what the cells hold, not by how they print it.
for (const table of document.querySelectorAll("table.sortable")) {
  const heads = [...table.tHead.rows[0].cells];
  heads.forEach((head, column) => head.querySelector("button").addEventListener("click", () => {
    const up = head.getAttribute("aria-sort") !== "ascending";
    heads.forEach((other) => other.removeAttribute("aria-sort"));
    head.setAttribute("aria-sort", up ? "ascending" : "descending");
    const key = (row) => {
      const cell = row.cells[column];
      return cell.dataset.v === undefined ? cell.textContent : Number(cell.dataset.v);
    };
    const before = (a, b) => {
      if (a === "" || b === "") return a === b ? 0 : a === "" ? 1 : -1; // what is not known comes last
      const order = typeof a === "number" && typeof b === "number" ? a - b : String(a).localeCompare(String(b));
      return up ? order : -order;
    };
    const body = table.tBodies[0];
    body.append(...[...body.rows].sort((a, b) => before(key(a), key(b))));
  }));
}
// Figures: each marker tells its line of the results.
const words = JSON.parse(document.getElementById("words").textContent);
const box = document.getElementById("hover");
const show = (marks, x, y) => {
  box.textContent = marks.map((mark) => words[mark.dataset.point]).join("\n\n");
  box.hidden = false;
  box.style.left = Math.max(4, Math.min(x + 14, innerWidth - box.offsetWidth - 8)) + "px";
  box.style.top = Math.max(4, Math.min(y + 14, innerHeight - box.offsetHeight - 8)) + "px";
};
for (const mark of document.querySelectorAll("figure svg g[id*='-line-']")) {
  mark.dataset.point = mark.id.replace(/^.*-line-/, "");
  mark.setAttribute("tabindex", "0");
  mark.setAttribute("role", "img");
  mark.setAttribute("aria-label", words[mark.dataset.point]);
  mark.addEventListener("mousemove", ({ clientX: x, clientY: y }) => {
    // Where markers lie on one another, all of them speak.
    const under = document.elementsFromPoint(x, y).map((part) => part.closest("[data-point]")).filter(Boolean);
    show([...new Set(under)], x, y);
  });
  mark.addEventListener("focus", () => {
    const place = mark.getBoundingClientRect();
    show([mark], place.right, place.bottom);
  });
  for (const end of ["mouseleave", "blur"]) mark.addEventListener(end, () => { box.hidden = true; });
}
