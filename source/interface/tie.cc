// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/interface/side_points.h>

namespace dovetail {

template <int dim>
bool Tie<dim>::evaluate_memory(Interface<dim> &interface, const double t, const ValuesOf &values_of)
{
  SidePoints<dim> points(interface, t);
  bool is_defined = true;
  for_each_group(interface, values_of, [&](const auto &group, const std::vector<double> &unknowns) {
    for (unsigned int q = group.begin; q < group.end; ++q) {
      interface.memory.keep_joint(q);
      for (const unsigned int side : {source, destination}) {
        points.reinit(side, q, unknowns);
        is_defined = points.evaluate(side, false) && is_defined;
        interface.memory.set_trial(side, q, points.state[side].memory.trial);
      }
    }
  });
  return is_defined;
}

template bool Tie<2>::evaluate_memory(Interface<2> &, double, const ValuesOf &);
template bool Tie<3>::evaluate_memory(Interface<3> &, double, const ValuesOf &);

} // namespace dovetail
