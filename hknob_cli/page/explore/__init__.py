"""``hknob explore``: a knob to play with, as one page with an engine of its own.

- `sheet` the cells of a sweep as the page takes them, or why not, and the HTML; ``page.html.j2``, ``page.css``
- ``engine/`` exact motion and the cycle reached, ``remedies.js`` what can be changed, ``view/`` what is seen and heard
"""
