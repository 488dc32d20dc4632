"""What is generated from the declarations is what the generator makes of them."""

from __future__ import annotations

import importlib.util
from types import ModuleType

import pytest
from tests.support import ROOT


def generator() -> ModuleType:
    """Import the script, which belongs to no package."""
    spec = importlib.util.spec_from_file_location("generate", ROOT / "tools" / "generate.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


GENERATE = generator()


@pytest.mark.parametrize("name", GENERATE.GENERATED)
def test_a_generated_file_is_what_is_made_now(name: str) -> None:
    written = (ROOT / name).read_text(encoding="utf-8")
    assert written == GENERATE.GENERATED[name](), f"{name} is stale: make generate"
