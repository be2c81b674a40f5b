"""How results are shown: style, numbers as text, tables, SVG, HTML."""
