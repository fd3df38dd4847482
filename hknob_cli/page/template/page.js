// Finds, sorts and filters, opens what the address points at, and says where the reader is. The page is whole without it.
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
    for (let one = target; one; one = one.parentElement) if (one.matches("details")) one.open = true;
    const fold = target.querySelector(":scope > details.fold");
    if (fold) fold.open = true;
    if (target.matches("#claims tbody")) reveal(target);
    target.scrollIntoView();
  };

  // What is wider than the screen is scrolled, by keys too, and says so.
  const scrolled = () => {
    for (const box of document.querySelectorAll(".ink, .rows .box")) {
      const wide = box.scrollWidth > box.clientWidth;
      if (wide) box.tabIndex = 0;
      else if (box.matches(".ink")) box.removeAttribute("tabindex");
      if (wide && !box.hint) {
        box.hint = document.createElement("p");
        box.hint.className = "hint";
        box.hint.textContent = "Wider than the screen: scroll it sideways.";
        box.before(box.hint);
      }
      if (box.hint) box.hint.hidden = !wide;
    }
  };

  // Whatever has a name of its own on the page, found by its words.
  const find = () => {
    const words = $("find-words"), list = $("find-list");
    const most = 40;
    let all;
    const gather = () => {
      const kinds = [
        ["Claim", "#claims tbody", (one) => [one.id, one.rows[0].cells[0].textContent + " " + one.rows[0].cells[1].textContent]],
        ["Figure", "figure", (one) => [one.id, one.querySelector("figcaption > p").textContent]],
        ["Table", ".rows", (one) => [one.id, one.querySelector("caption").textContent]],
        ["Chapter", "section.folded", (one) => [one.id, one.querySelector("h2").textContent]],
      ];
      return kinds.flatMap(([kind, which, say]) =>
        [...document.querySelectorAll(which)].map((one) => {
          const [id, text] = say(one);
          return { kind, id, text: text.replace(/\s+/g, " ").trim(), words: text.toLowerCase() };
        }),
      );
    };
    words.addEventListener("input", () => {
      const wanted = words.value.toLowerCase().split(/\s+/).filter(Boolean);
      all ||= gather();
      const found = wanted.length ? all.filter((one) => wanted.every((word) => one.words.includes(word))) : [];
      list.replaceChildren(
        ...found.slice(0, most).map((one) => {
          const link = document.createElement("a"), kind = document.createElement("b"), item = document.createElement("li");
          link.href = "#" + encodeURIComponent(one.id);
          kind.textContent = one.kind;
          link.append(kind, " " + (one.text.length > 110 ? one.text.slice(0, 109) + "\u2026" : one.text));
          item.append(link);
          return item;
        }),
      );
      const more = found.length > most ? `, the first ${most} are shown` : "";
      $("find-count").textContent = wanted.length ? `${found.length} found${more}` : "";
      $("contents-list").hidden = $("contents-title").hidden = wanted.length > 0;
    });
    $("find").hidden = false;
  };

  // Where the reader is, in the contents.
  const spy = () => {
    const links = new Map([...document.querySelectorAll("#contents-list a")].map((one) => [one.hash.slice(1), one]));
    const watch = new IntersectionObserver(
      (seen) => {
        for (const { target, isIntersecting } of seen) {
          const link = links.get(target.id);
          if (isIntersecting) link.setAttribute("aria-current", "true");
          else link.removeAttribute("aria-current");
        }
      },
      { rootMargin: "-15% 0px -84% 0px" },
    );
    for (const id of links.keys()) watch.observe($(id));
  };

  // Paper shows everything.
  let opened = [];
  addEventListener("beforeprint", () => {
    opened = [...document.querySelectorAll("details.fold:not([open]), details.part:not([open])")];
    for (const one of opened) one.open = true;
  });
  addEventListener("afterprint", () => {
    for (const one of opened) one.open = false;
  });

  const table = document.querySelector("#claims table");
  if (table) tabulate(table);
  find();
  spy();
  addEventListener("hashchange", follow);
  addEventListener("resize", scrolled);
  document.addEventListener("toggle", scrolled, true);
  document.addEventListener("click", (event) => {
    const link = event.target.closest("a[href^='#']");
    if (link && link.hash === location.hash) follow();
  });
  scrolled();
  follow();
})();
