"""Scalars per material point from the fields of a grid."""
import numpy as np

from . import PlotError

_COMPONENTS = {3: ["x", "y", "z"], 6: ["xx", "yy", "zz", "xy", "yz", "xz"], 9: [str(i) for i in range(1, 10)]}
GRADIENT = "deformation gradient"
SHEAR_STRAIN = "shear strain"


def evaluate(data, field):
    """A scalar per cell: "volume", "stress_xx", "displacement" or "displacement magnitude" (the norm of a vector),
    "mean stress" (a third of the trace), "deviatoric stress" (von Mises) or "shear strain" (see shear_strain)."""
    if field in ("mean stress", "deviatoric stress") and "stress" in data:
        stress = data["stress"]
        mean = stress[:, :3].sum(axis=1) / 3.
        if field == "mean stress":
            return mean
        deviator = stress[:, :3] - mean[:, None]
        return np.sqrt(1.5 * (deviator**2).sum(axis=1) + 3. * (stress[:, 3:]**2).sum(axis=1))
    if field == SHEAR_STRAIN:
        if GRADIENT not in data:
            raise PlotError(f"\"{SHEAR_STRAIN}\" needs the field \"{GRADIENT}\", which the run has not written; add it "
                            "to \"vtk material point fields\" in the input")
        return shear_strain(data[GRADIENT].reshape(-1, 3, 3))
    name = field[:-len(" magnitude")] if field.endswith(" magnitude") else field
    if name in data:
        values = data[name]
        if values.ndim == 1:
            return values
        if values.shape[1] == 3:
            return np.linalg.norm(values, axis=1)
    base, _, component = field.rpartition("_")
    if base in data and data[base].ndim == 2 and component in _COMPONENTS.get(data[base].shape[1], []):
        return data[base][:, _COMPONENTS[data[base].shape[1]].index(component)]
    raise PlotError(f"no field \"{field}\"; there are: {', '.join(_field_names(data))}")


def shear_strain(gradient):
    """Equivalent shear strain sqrt(2/3 e:e) of deformation gradients (n, 3, 3), where e is the deviator of the total
    logarithmic strain ln V: 1/sqrt(3) of the engineering shear strain in small simple shear, and the axial strain in
    extension at constant volume."""
    gradient = np.asarray(gradient, dtype=float)
    stretches = np.linalg.eigvalsh(gradient @ gradient.transpose(0, 2, 1))
    strain = 0.5 * np.log(np.maximum(stretches, np.finfo(float).tiny))
    deviator = strain - strain.mean(axis=1, keepdims=True)
    return np.sqrt(2. / 3. * (deviator**2).sum(axis=1))


def _field_names(data):
    names = []
    for name, values in sorted(data.items()):
        if values.ndim == 1:
            names.append(name)
        else:
            names += [name] if values.shape[1] == 3 else []
            names += [f"{name}_{component}" for component in _COMPONENTS.get(values.shape[1], [])]
    names += ["mean stress", "deviatoric stress"] if "stress" in data else []
    return names + ([SHEAR_STRAIN] if GRADIENT in data else [])
