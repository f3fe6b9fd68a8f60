"""Fields of the documents that omni-bench writes. A file may contain anything: missing fields are None or empty."""

MOST = 1e30  # larger values are not figures


class Unusable(Exception):
    """A document that cannot be drawn: what is missing, and what to do."""


def number(row, key):
    value = row.get(key)
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        return None
    return float(value) if abs(value) < MOST else None  # false for NaN


def finite(row, *keys):
    """The numbers of `keys`; None if one is missing."""
    values = [number(row, key) for key in keys]
    return None if None in values else values


def positive(row, *keys):
    values = finite(row, *keys)
    return values if values and min(values) > 0 else None


def word(row, key):
    value = row.get(key)
    return value if isinstance(value, str) else ""


def objects(rows):
    return [row for row in rows if isinstance(row, dict)] if isinstance(rows, list) else []


def table(document, name):
    return objects(document["tables"].get(name)) if isinstance(document.get("tables"), dict) else []


def group(items, key):
    """Key -> items, keys in order of their first item."""
    groups = {}
    for item in items:
        groups.setdefault(key(item), []).append(item)
    return groups


def read_series(document, rows, name_key, *keys):
    """Name -> points of `keys` above zero, each followed by its row; names in order of their first row."""
    points = [(*positive(row, *keys), row) for row in rows if positive(row, *keys) and word(row, name_key)]
    if not points:
        raise Unusable(f"no row has {name_key}, {', '.join(keys)}; make it with omni-bench {word(document, 'name')}")
    return group(points, lambda point: word(point[-1], name_key))


def columns(points, count=2):
    """The first `count` numbers of all points, one list each; empty without points."""
    return list(zip(*(point[:count] for point in points))) or [()] * count


def all_points(series):
    return [point for points in series.values() for point in points]


def kind_of(name):
    return name.split(",")[0]  # "free strokes, seed 7": what follows the comma says which one
