// The base's supply: a source with a resistance and a diode, and the capacitor beside the bridges. It sags under load;
// what sleeping bridges give back has nowhere to go but into the capacitor.
#pragma once

namespace omni::sim {

struct SupplyParameters {
  double source_ohm = 0.05;     // source, cable and diode; assumption
  double capacitance_F = 1e-3;  // of the bridges' boards together; assumption, the worst of those considered
  double quiescent_A = 0.1;     // controller, sensors, fan; assumption
  double clamp_V = 33;          // a transient suppressor stands across it
};

class SupplyRail {
 public:
  SupplyRail(const SupplyParameters& parameters, double source_V) noexcept
      : parameters_(parameters), source_V_(source_V), rail_V_(source_V) {}

  void SetSource(double source_V) noexcept { source_V_ = source_V; }

  // The bridges draw `load_A` over the step; < 0: they give back.
  //   C dV/dt = (V0 - V) / Rs - I   while V < V0, without the first term above it
  void Step(double load_A, double dt_s) noexcept;

  double voltage_V() const noexcept { return rail_V_; }

 private:
  SupplyParameters parameters_;
  double source_V_;
  double rail_V_;
};

}  // namespace omni::sim
