// Sorts and filters the table of claims, and opens what the address points at. The page is whole without it.
(() => {
  "use strict";
  const $ = (id) => document.getElementById(id);
  const natural = new Intl.Collator("en", { numeric: true });
  let reveal = () => {};

  const tabulate = (table) => {
    const rows = [...table.tBodies];
    const text = new Map(rows.map((row) => [row, row.textContent.toLowerCase()]));
    const boxes = [...document.querySelectorAll("#claims-controls input[name=verdict]")];
    const part = $("claims-part"), words = $("claims-words");

    const filter = () => {
      const verdicts = boxes.filter((box) => box.checked).map((box) => box.value);
      const wanted = words.value.toLowerCase().split(/\s+/).filter(Boolean);
      let shown = 0;
      for (const row of rows) {
        row.hidden = !(
          (!verdicts.length || verdicts.includes(row.dataset.verdict)) &&
          (!part.value || row.dataset.part === part.value) &&
          wanted.every((word) => text.get(row).includes(word))
        );
        shown += !row.hidden;
      }
      $("claims-count").textContent = `${shown} of ${rows.length}`;
      $("claims-nothing").hidden = shown > 0;
      table.hidden = !shown;
      $("claims-all").hidden = !(verdicts.length || part.value || wanted.length);
    };
    const clear = (verdict) => {
      for (const box of boxes) box.checked = box.value === verdict;
      part.value = words.value = "";
      filter();
    };
    const sort = (header) => {
      const was = header.getAttribute("aria-sort");
      const order = !was ? "ascending" : was === "ascending" ? "descending" : "";
      for (const other of header.parentNode.cells) other.removeAttribute("aria-sort");
      if (order) header.setAttribute("aria-sort", order);
      const sign = order === "descending" ? -1 : 1;
      const key = (row) => row.rows[0].cells[header.cellIndex].dataset.key;
      const compare = header.dataset.sort === "number" ? (a, b) => a - b : natural.compare;
      // Rows without a value come last either way.
      const by = (a, b) => !key(a) - !key(b) || sign * compare(key(a), key(b));
      table.append(...(order ? [...rows].sort(by) : rows));
    };

    for (const header of table.querySelectorAll("th[data-sort]")) {
      const button = document.createElement("button");
      button.type = "button";
      button.append(...header.childNodes);
      button.addEventListener("click", () => sort(header));
      header.append(button);
    }
    for (const control of [...boxes, part, words]) control.addEventListener("input", filter);
    $("claims-all").addEventListener("click", () => {
      clear();
      words.focus();
    });
    for (const link of document.querySelectorAll("a[data-verdict]")) {
      link.addEventListener("click", () => clear(link.dataset.verdict));
    }
    reveal = (row) => {
      if (row.hidden) clear();
      row.querySelector("details").open = true;
    };
    $("claims-controls").hidden = false;
    filter(); // what the browser has kept of the controls after a reload
  };

  const follow = () => {
    let id = location.hash.slice(1);
    try {
      id = decodeURIComponent(id);
    } catch {
      return;
    }
    const target = id && $(id);
    if (!target) return;
    if (target.matches("#claims tbody")) reveal(target);
    target.scrollIntoView();
  };

  // A figure that is wider than the screen is scrolled, by keys too.
  const scrolled = () => {
    for (const ink of document.querySelectorAll(".ink")) {
      if (ink.scrollWidth > ink.clientWidth) ink.tabIndex = 0;
      else ink.removeAttribute("tabindex");
    }
  };

  const table = document.querySelector("#claims table");
  if (table) tabulate(table);
  addEventListener("hashchange", follow);
  addEventListener("resize", scrolled);
  scrolled();
  follow();
})();
