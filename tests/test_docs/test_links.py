"""Links between the README, the documentation's pages and files of this project."""

import os

import pages
import pytest

MADE_BY_THE_SITE = ("docs/pictures/", "docs/api/")
"""What the site's build makes: Sphinx, which warns of what is missing, is its test."""
LINKS = [(page, *link) for page in pages.PAGES for link in pages.links(page)]
ENOUGH = 40
"""Links: fewer would mean that they aren't found."""


def test_links_are_found():
    assert len(LINKS) >= ENOUGH


@pytest.mark.parametrize(("page", "path", "anchor"), LINKS)
def test_a_link_leads_to_something(page, path, anchor):
    target = os.path.normpath(os.path.join(os.path.dirname(page), path)) if path else page
    if target.startswith(MADE_BY_THE_SITE):
        return
    assert (pages.ROOT / target).exists(), f"{page}: {path}"
    if anchor:
        assert anchor in pages.anchors(target), f"{page}: {path}#{anchor}"


def test_every_page_is_in_the_sites_contents():
    contents = pages.text_of("docs/index.md")
    listed = {f"docs/{line}.md" for line in contents.split()}
    own = {page for page in pages.PAGES if page.startswith("docs/")} - {"docs/index.md"}
    assert own <= listed
