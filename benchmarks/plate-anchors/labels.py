"""Names of cases in tables and charts."""
import dataclasses

# By field of a case: text, factor from SI, unit.
NAMES = {
    "cell": ("cells at the plate", 1e3, "mm"), "around": ("around it", 1e3, "mm"), "reach": ("up to", 1e3, "mm"),
    "base": ("beyond", 1e3, "mm"), "depth": ("depth", 1., "m"), "half_width": ("half width", 1., "m"),
    "velocity": ("", 1e3, "mm/s"), "mass_scaling": ("mass scaling", 1., ""), "young": ("E", 1e-6, "MPa"),
    "dilation_angle": ("ψ", 1., "°"), "roughness": ("tan δ / tan φ", 1., ""),
    "edge_radius": ("edges rounded by", 1e3, "mm"), "box_length": ("box", 1., "m long"),
    "friction_angle": ("φ", 1., "°"), "K0": ("K0", 1., "")}
DYNAMIC = ("velocity", "mass_scaling")  # mean nothing in static equilibrium
UNSAID = ("ahead", "distance")  # the analysis and the length of the curve say it


def has_own_tolerance(case):
    """Whether a case has another tolerance than the study."""
    return case.tolerance != type(case).tolerance


def tolerance(case, separator=""):
    """Text for the tolerance, behind a separator; empty where it is the study's own."""
    return f"{separator}residuals {100. * case.tolerance:g} %" if has_own_tolerance(case) else ""


def label(case, cases):
    """What distinguishes a case from the others of its part."""
    said = []
    for name in (field.name for field in dataclasses.fields(case)):
        if name in UNSAID or len({getattr(other, name) for other in cases}) == 1:
            continue
        value = getattr(case, name)
        if name == "tolerance":
            said += [tolerance(case)] if has_own_tolerance(case) else []
        elif isinstance(value, bool):
            said += [name] if value else []
        elif isinstance(value, str):
            said.append(value)
        elif case.analysis != "static" or name not in DYNAMIC:
            text, factor, unit = NAMES.get(name, (name.replace("_", " "), 1., ""))
            said.append(f"{text} {factor * value:g} {unit}".strip())
    return ", ".join(said) or case.name
