"""Finding scenes: folders with a ``model.py`` that defines one `ParticleModel`."""

from __future__ import annotations

import ast
import difflib
import hashlib
import importlib
import importlib.util
import inspect
import sys
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING, Any

import apmethod.scenes

if TYPE_CHECKING:
    from apmethod.model import ParticleModel


def shipped_scenes() -> list[str]:
    """Names of the scenes that come with the package."""
    found = {
        folder.parent.name
        for home in apmethod.scenes.__path__
        for folder in Path(home).glob("*/model.py")
    }
    return sorted(found)


def load_scene(scene: str | Path) -> type[ParticleModel]:
    """The model class of a scene.

    Args:
        scene: path of the scene's folder (or of a file in it), or a shipped scene's name.

    Raises:
        ValueError: if there is no such scene, or its ``model.py`` does not define exactly
            one model class.
    """
    path = Path(scene)
    folder = path.parent if path.is_file() else path
    if (folder / "model.py").is_file():
        return _model_class(_import_folder(folder.resolve()))
    if str(scene) in shipped_scenes():
        return _model_class(importlib.import_module(f"apmethod.scenes.{scene}.model"))
    near = difflib.get_close_matches(path.name, shipped_scenes(), n=1)
    hint = f"; did you mean {near[0]!r}?" if near else ""
    raise ValueError(
        f"scene is {str(scene)!r}, which is neither a folder with a model.py nor one of "
        f"{', '.join(shipped_scenes())}{hint}"
    )


def _import_folder(folder: Path) -> ModuleType:
    """``model.py`` of a folder, imported as part of a package so that it can use siblings."""
    for home in apmethod.scenes.__path__:
        if folder.parent == Path(home).resolve():
            return importlib.import_module(f"apmethod.scenes.{folder.name}.model")
    # The same name in every process, or machine code cached under it would not load.
    name = f"apmethod_scene_{hashlib.sha256(str(folder).encode()).hexdigest()[:12]}"
    if name not in sys.modules:
        package = ModuleType(name)
        package.__path__ = [str(folder)]
        sys.modules[name] = package
    return importlib.import_module(f"{name}.model")


def _model_class(module: ModuleType) -> type[ParticleModel]:
    from apmethod.model import ParticleModel

    found = [
        value
        for value in vars(module).values()
        if isinstance(value, type)
        and issubclass(value, ParticleModel)
        and value.__module__ == module.__name__
    ]
    if len(found) != 1:
        names = ", ".join(cls.__name__ for cls in found) or "none"
        raise ValueError(f"{module.__file__} must define one ParticleModel; it defines {names}")
    return found[0]


def build(scene: type[ParticleModel], settings: dict[str, Any]) -> ParticleModel:
    """A model of the scene with the given constructor arguments.

    Raises:
        ValueError: for an argument that the scene does not have; a near match is named.
    """
    accepted = [name for name in inspect.signature(scene.__init__).parameters if name != "self"]
    for name in settings:
        if name not in accepted:
            near = difflib.get_close_matches(name, accepted, n=1)
            hint = f"did you mean {near[0]!r}? " if near else ""
            raise ValueError(
                f"{scene.__name__} has no setting {name!r}; {hint}it has {', '.join(accepted)}"
            )
    return scene(**settings)


def parse_setting(text: str) -> tuple[str, Any]:
    """``name=value`` as a name and a Python value; what is no literal is a string.

    Raises:
        ValueError: for a text without ``=``.
    """
    name, equals, value = text.partition("=")
    if not equals or not name.strip():
        raise ValueError(f"--set is {text!r}; it must be name=value")
    try:
        return name.strip(), ast.literal_eval(value)
    except (SyntaxError, ValueError):
        return name.strip(), value
