// Names for what the theme leaves without one, and a place among the keys for what can only be scrolled.
document$.subscribe(() => {
  document.querySelector(".md-search")?.setAttribute("aria-label", "Search")
  document.getElementById("__search")?.setAttribute("aria-label", "Search")
  document.getElementById("__drawer")?.setAttribute("aria-label", "Menu")
  for (const wide of document.querySelectorAll(".md-typeset__scrollwrap, .md-typeset pre > code")) wide.tabIndex = 0
  document.querySelectorAll(".md-code__nav").forEach((one, i) => one.setAttribute("aria-label", `Code ${i + 1}`))
})
