"""Arrays whose last axis has names."""

from __future__ import annotations

import numpy as np

from ._errors import InputError, no_joint


class NamedArray(np.ndarray):
    """A numpy array whose entries along the last axis also go by the names of joints.

    ``q["elbow"]`` is the number of a joint of one coordinate, or a view of those of a joint of several; of an array of samples, a view of the
    joint's columns. Everything else is as with any numpy array.
    """

    _places: dict[str, tuple[int, int]] | None

    def __new__(cls, numbers, places):
        array = np.asarray(numbers, dtype=float).view(cls)
        array._places = {name: (first, last) for name, first, last in places}
        return array

    def __array_wrap__(self, array, context=None, return_scalar=False):
        # A sum or a largest entry is a number.
        return array[()] if array.ndim == 0 else super().__array_wrap__(array, context, return_scalar)

    def __array_finalize__(self, other):
        # Parts and results of arithmetic have other axes.
        self._places = None

    def alike(self):
        """Another array with the same numbers and names."""
        array = np.array(self).view(NamedArray)
        array._places = self._places
        return array

    def _place(self, name):
        if self._places is None:
            raise InputError(f"this array has no names; ask the whole array for {name!r}")
        if name not in self._places:
            raise no_joint(name, self._places)
        first, last = self._places[name]
        return (..., first) if last == first + 1 else (..., slice(first, last))

    def __getitem__(self, key):
        if isinstance(key, str):
            part = np.asarray(self)[self._place(key)]
            return part if part.ndim else float(part)
        return super().__getitem__(key)

    def __setitem__(self, key, value):
        if isinstance(key, str):
            place = self._place(key)
            wanted = np.asarray(self)[place].shape
            given = np.shape(value)
            if given != wanted and given != ():
                raise InputError(f"joint {key!r} has {wanted or 'one number'}, not {given}")
            np.asarray(self)[place] = value
            return
        super().__setitem__(key, value)

    def keys(self):
        """The names."""
        return list(self._places or ())
