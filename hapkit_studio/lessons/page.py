"""An HTML page that contains its style and needs no other files."""

import html

_STYLE = """
:root { color-scheme: light; --ink: #1b2330; --soft: #5a6675; --line: #d5dbe3; --blue: #0b5cab; }
* { box-sizing: border-box; }
body { font: 16px/1.5 system-ui, "Segoe UI", Roboto, sans-serif; color: var(--ink); background: #fff;
  max-width: 52rem; margin: 0 auto; padding: 1rem 1rem 3rem; overflow-wrap: anywhere; }
body.table { max-width: 100rem; }
h1 { font-size: 1.6rem; line-height: 1.25; margin: .5rem 0; }
h2 { font-size: 1.2rem; margin: 2rem 0 .5rem; border-top: 1px solid var(--line); padding-top: 1rem; }
.soft, caption, figcaption { color: var(--soft); font-size: .9rem; }
table { border-collapse: collapse; width: 100%; }
th, td { text-align: left; vertical-align: top; padding: .35rem .5rem; border-bottom: 1px solid var(--line); }
.wide { overflow-x: auto; }
.wide table { font-size: .85rem; overflow-wrap: normal; }
.task { border: 1px solid var(--line); border-left: .35rem solid var(--soft); border-radius: .4rem;
  padding: .6rem .8rem; margin: .6rem 0; break-inside: avoid; }
.task p { margin: .2rem 0; }
.task.correct { border-left-color: #1a7f37; } .task.wrong, .task.edited { border-left-color: #b42318; }
.state { font-weight: 600; } .correct .state { color: #1a7f37; }
.wrong .state, .edited .state, .damaged .state { color: #b42318; }
tr.edited td, tr.damaged td { background: #fdecea; }
tr.wrong td:nth-child(7) { color: #b42318; }
tr.correct td:nth-child(7) { color: #1a7f37; }
pre { white-space: pre-wrap; background: #f5f7fa; padding: .6rem .8rem; border-radius: .4rem;
  margin: .3rem 0; }
figure { margin: 1rem 0; break-inside: avoid; overflow-x: auto; }
figure svg { width: 100%; min-width: 34rem; height: auto; display: block; }
.math { margin: .8rem 0 .8rem 1rem; font-size: 1.15rem; overflow-x: auto; }
svg.formula { display: inline-block; overflow: visible; max-width: none; }
dl { display: grid; grid-template-columns: max-content 1fr; gap: .2rem 1rem; margin: .5rem 0; }
dt { color: var(--soft); } dd { margin: 0; }
@media (max-width: 34rem) { dl { grid-template-columns: 1fr; } dd { margin-bottom: .4rem; } }
@media print { body { max-width: none; padding: 0; font-size: 11pt; } figure { overflow: visible; }
  figure svg { min-width: 0; } h2 { break-after: avoid; } }
"""
_POLICY = "default-src 'none'; style-src 'unsafe-inline'"


def page(title: str, body: str, wide: bool = False) -> str:
    """Return a page; ``body`` is HTML with escaped text. A browser loads no other files.

    If ``wide`` is True, the page is wider than usual, because it shows a table.
    """
    kind = ' class="table"' if wide else ""
    return (
        '<!DOCTYPE html>\n<html lang="en"><head><meta charset="utf-8">'
        f'<meta http-equiv="Content-Security-Policy" content="{_POLICY}">'
        '<meta name="viewport" content="width=device-width, initial-scale=1">'
        f"<title>{html.escape(title)}</title><style>{_STYLE}</style></head>\n<body{kind}>{body}</body></html>\n"
    )
