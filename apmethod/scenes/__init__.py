"""The shipped scenes, importable as ``apmethod.scenes.<name>``.

An installed wheel has their folders beside this file; in a checkout they are the folders
of ``models``.
"""

from pathlib import Path

_checkout = Path(__file__).parents[2] / "models"
if _checkout.is_dir():
    __path__.append(str(_checkout))
