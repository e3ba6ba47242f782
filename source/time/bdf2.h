// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Backward differences of order two, whose first rates other schemes take.

#pragma once

#include <dovetail/time/time_scheme.h>

namespace dovetail {

/// Backward differences of order two; see bdf2.cc.
class Bdf2 : public TimeScheme
{
public:
  explicit Bdf2(const Section & /*steps*/) {}

  std::string description() const override { return "BDF2, of order 2"; }
  unsigned int order() const override { return 2; }
  Rates rates(const StepTime &step) const override;

protected:
  void find_rates(const StepTime &step, const Vector &x, Vector &rate,
                  std::vector<Vector> &second_rates) const override;
  unsigned int n_states() const override { return 2; }
  Rates first_rates(const StepTime &step) const;

private:
  double ratio(const StepTime &step, bool starts_anew) const;
};

} // namespace dovetail
