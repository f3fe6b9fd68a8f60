"""Every number of the drawings: the value of a formula over the keys of the sources."""
import math

from drafting.magnetics import MU0, legendre_slopes, mutual_H
from drafting.sources import read


class Facts:
    """facts("omni.hull.hull_radius_m"): the value of a formula. Coils and layers count from 0, from the inside out."""

    def __init__(self, folder):
        self.names = {"__builtins__": {}, **read(folder), "pi": math.pi}
        self.omni, self.build, self.twin = (self.names[name] for name in ("omni", "build", "twin"))
        for function in (sum, range, math.sqrt, math.hypot):
            self.names[function.__name__] = function
        self.names |= {name: getattr(self, name) for name in dir(type(self)) if not name.startswith("_")}
        self.kept = {}

    def __call__(self, formula):
        return eval(formula, self.names)  # pylint: disable=eval-used  (formulas of these files and of their test)

    def mm(self, formula):
        return 1e3 * self(formula)

    # Shells: layer n of coil k is shell 3 n + k of 18, as in service/magnetics/coil.cc.
    def pitch_m(self):
        coil = self.omni.coils[0]
        return (coil.shell_radius_max_m - coil.shell_radius_min_m) / (3 * coil.layers)

    def shell_m(self, k, layer):
        return self.omni.coils[k].shell_radius_min_m + (3 * layer + k + 0.5) * self.pitch_m()

    def turns_in(self, k, layer):
        coil = self.omni.coils[k]
        return coil.turns // coil.layers + (layer >= coil.layers - coil.turns % coil.layers)

    # The turns of a layer lie side by side: its edge is half their width along the sphere from the middle.
    def edge_angle(self, k, layer):
        return self.turns_in(k, layer) * self.build.former.turn_pitch_m / 2 / self.shell_m(k, layer)

    def edge_m(self, k, layer):
        return self.shell_m(k, layer) * math.sin(self.edge_angle(k, layer))

    def edge_radius_m(self, k, layer):
        return self.shell_m(k, layer) * math.cos(self.edge_angle(k, layer))

    def turns(self, k, model):
        """(radius, height) of each turn; model: evenly over omni.toml's band, as service/magnetics/coil.cc has them."""
        result, coil = [], self.omni.coils[k]
        for layer in range(coil.layers):
            R, count = self.shell_m(k, layer), self.turns_in(k, layer)
            for n in range(count):
                share = (2 * n + 1) / count - 1
                z = coil.band_half_width_m * share if model else R * math.sin(share * self.edge_angle(k, layer))
                result.append((math.sqrt(R * R - z * z), z))
        return result

    def length_m(self, k, model=False):
        return 2 * math.pi * sum(radius for radius, _ in self.turns(k, model))

    def model_length_m(self, k):
        return self.length_m(k, True)

    def inductances_H(self, k, model):
        """Of the winding in air, of the core's answer: sum over l of kappa_l 4 pi b_l^2 a^(2l+1) / (mu0 l^2), the
        core's moments times the field that they link [docs/theory/magnetics.md (13) to (15)]."""
        if (k, model) in self.kept:
            return self.kept[k, model]
        turns, core = self.turns(k, model), self.omni.core
        own = self.build.wire.bare_m / 2 * math.exp(-0.25)  # geometric mean distance of a round wire's section
        air = sum(mutual_H(r, r, own) for r, _ in turns)
        air += 2 * sum(mutual_H(r, s, y - z) for i, (r, y) in enumerate(turns) for s, z in turns[:i])
        b = [0.0] * 7
        for rho, z in turns:
            R = math.hypot(rho, z)
            for j, slope in enumerate(legendre_slopes(z / R, len(b))):
                b[j] += MU0 * rho * rho * slope / (2 * R ** (2 * j + 3))
        answer = 0.0
        for j, b_l in enumerate(b):
            l, kappa = 2 * j + 1, core.core_kappa
            kappa_l = 3 * l * kappa / (2 * l + 1 + kappa * (l - 1))
            answer += kappa_l * 4 * math.pi * b_l ** 2 * core.core_radius_m ** (2 * l + 1) / (MU0 * l * l)
        self.kept[k, model] = air, answer
        return air, answer

    def inductance_H(self, k):
        return sum(self.inductances_H(k, False))

    def model_inductance_H(self, k):
        return sum(self.inductances_H(k, True))

    def inductance_at_H(self, k, Hz):
        """What a meter shows: eddy currents weaken the core, H(s) = (1 - sqrt(s/w)/2) / (1 + sqrt(s/w)),
        w = mu_r / (mu0 sigma a^2) [docs/theory/truth.md]."""
        core = self.twin.core
        w = core.core_permeability / (MU0 * core.core_conductivity_S_m * self.omni.core.core_radius_m ** 2)
        root = (2j * math.pi * Hz / w) ** 0.5
        air, answer = self.inductances_H(k, False)
        return air + answer * ((1 - root / 2) / (1 + root)).real

    def resistance_ohm(self, k, C):
        return self.omni.coils[k].resistance_20C_ohm * (1 + self.twin.thermal.resistance_per_K * (C - 20))

    def wire_ohm(self, k, C):
        """Of the wire that is wound, with its two ends."""
        wire = self.build.wire
        return (wire.resistivity_ohm_m * (1 + self.twin.thermal.resistance_per_K * (C - 20)) *
                (self.length_m(k) + 2 * wire.lead_m) / (math.pi / 4 * wire.bare_m ** 2))

    def mass_kg(self, k):
        return self.build.wire.density_kg_m3 * math.pi / 4 * self.build.wire.bare_m ** 2 * self.length_m(k)

    def hot_C(self, k, from_C, s):
        """The copper s seconds after the whole supply lies across coil k, if no heat leaves it. With u = T - 20 C:
        R20 (1 + a u) C du = U^2 dt, so u + a u^2 / 2 = u0 + a u0^2 / 2 + U^2 t / (C R20)."""
        a, u0 = self.twin.thermal.resistance_per_K, from_C - 20
        there = u0 + a * u0 * u0 / 2 + self.omni.limits.supply_V ** 2 * s / (
            self.omni.heat.copper_J_K * self.omni.coils[k].resistance_20C_ohm)
        return 20 + (math.sqrt(1 + 2 * a * there) - 1) / a

    def duty(self, k, A, C):
        return A * self.resistance_ohm(k, C) / self.omni.limits.supply_V

    def lean(self):
        """The pen where nib and rim touch the hull together: the angle between its axis and the line from magnet to
        core, and that line's length. The hull's centre is R from the rim and R + n from the nib's centre, which is the
        middle of the magnet's face; (across, along): from there to the hull's centre."""
        magnet, R = self.omni.magnet, self.omni.hull.hull_radius_m
        n = magnet.tip_offset_m - magnet.half_height_m
        across = (magnet.radius_m ** 2 + (R + n) ** 2 - R ** 2) / (2 * magnet.radius_m)
        along = math.sqrt((R + n) ** 2 - across ** 2) + magnet.half_height_m
        return math.atan2(across, along), math.hypot(across, along)
