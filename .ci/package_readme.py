"""Makes the README of the package: away from the checkout its relative links lead nowhere."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

from hatchling.metadata.plugin.interface import MetadataHookInterface

PICTURE = re.compile(r"^!\[[^\]]*\]\((?!\w+:)[^)]+\)\n+", re.MULTILINE)
LINK = re.compile(r"\[([^\]]+)\]\((?!\w+:)[^)]+\)")


class PackageReadme(MetadataHookInterface):
    """Gives the metadata a README whose relative links are their text, without pictures."""

    def update(self, metadata: dict[str, Any]) -> None:
        """Fill in the field that is dynamic."""
        text = (Path(self.root) / "README.md").read_text(encoding="utf-8")
        text = LINK.sub(r"\1", PICTURE.sub("", text))
        metadata["readme"] = {"content-type": "text/markdown", "text": text}
