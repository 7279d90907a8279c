"""How to cite the program and the paper whose valve it simulates, from CITATION.cff."""

from pathlib import Path
from typing import Any

import yaml

FILE = Path(__file__).parent.parent.parent / "CITATION.cff"


def write_citation() -> str:
    """The citation as a line for a list of references, and as BibTeX."""
    about = yaml.safe_load(FILE.read_text(encoding="utf-8"))
    (paper,) = about["references"]
    authors, year = _join_names(about["authors"]), str(about["date-released"])[:4]
    doi = paper["doi"]
    lines = [
        f"{about['message']}",
        "",
        f"> {authors}: *{about['title']}*, version {about['version']}, {year}. {about['abstract']}",
        "",
        f"> {_end(paper['title'])} *{paper['journal']}*, {paper['year']}, [doi {doi}](https://doi.org/{doi}).",
        "",
        "```bibtex",
        f"@software{{{about['title']},",
        f"  author = {{{{{authors}}}}},",
        f"  title = {{{about['title']}: {about['abstract'].rstrip('.')}}},",
        f"  version = {{{about['version']}}},",
        f"  year = {{{year}}},",
        f"  license = {{{about['license']}}},",
        "}",
        "",
        "@article{epv_paper,",
        f"  title = {{{paper['title']}}},",
        f"  journal = {{{paper['journal']}}},",
        f"  year = {{{paper['year']}}},",
        f"  doi = {{{doi}}},",
        "}",
        "```",
    ]
    return "\n".join(lines) + "\n"


def _join_names(authors: list[dict[str, Any]]) -> str:
    """Names of authors, of persons and of groups."""
    return ", ".join(author.get("name") or f"{author['given-names']} {author['family-names']}" for author in authors)


def _end(sentence: str) -> str:
    """A title with a full stop."""
    return f"{sentence.rstrip('.')}."
