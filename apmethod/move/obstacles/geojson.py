"""Obstacles from GeoJSON and from shapely's geometries."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from apmethod.move.obstacles.shapes import Obstacle, Polygon, Polyline


def from_shapely(geometry: Any, **options: Any) -> list[Obstacle]:
    """The obstacles of a shapely geometry, or of anything with ``__geo_interface__``.

    Args:
        geometry: polygons and lines, and collections of them.
        options: see `Obstacle`; they hold for each.
    """
    return _of_geometry(geometry.__geo_interface__, options)


def from_geojson(source: str | Path | Mapping[str, Any], **options: Any) -> list[Obstacle]:
    """The obstacles of a GeoJSON file (RFC 7946) or object; coordinates are taken as they are.

    A feature's properties "name", "behaviour", "velocity", "spin" and "pivot" are options of
    its obstacles; other properties are left alone.

    Args:
        source: path of a file, or what json.load gives of one.
        options: see `Obstacle`; a feature's own go before them.

    Raises:
        ValueError: for a geometry that is neither polygons nor lines.
    """
    data = source if isinstance(source, Mapping) else json.loads(Path(source).read_text())
    features = data["features"] if data.get("type") == "FeatureCollection" else [data]
    found: list[Obstacle] = []
    for feature in features:
        own: dict[str, Any] = {}
        if feature.get("type") == "Feature":
            known = ("name", "behaviour", "velocity", "spin", "pivot")
            properties = feature.get("properties") or {}
            own = {key: properties[key] for key in known if key in properties}
            feature = feature["geometry"]
        found += _of_geometry(feature, options | own)
    return found


def _of_geometry(geometry: Mapping[str, Any], options: Mapping[str, Any]) -> list[Obstacle]:
    kind = geometry["type"]
    if kind == "GeometryCollection":
        return [o for part in geometry["geometries"] for o in _of_geometry(part, options)]
    parts = geometry["coordinates"] if kind.startswith("Multi") else [geometry["coordinates"]]
    if kind in ("Polygon", "MultiPolygon"):
        return [Polygon(_flat(part[0]), [_flat(h) for h in part[1:]], **options) for part in parts]
    if kind in ("LineString", "MultiLineString", "LinearRing"):
        return [Polyline(_flat(part), **options) for part in parts]
    raise ValueError(f"geometry is a {kind}; it must be polygons or lines")


def _flat(points: Sequence[Sequence[float]]) -> list[Sequence[float]]:
    """Without heights."""
    return [point[:2] for point in points]
