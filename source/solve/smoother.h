// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// What improves a solution on one level of multigrid.

#pragma once

namespace dovetail {

class Smoother
{
public:
  virtual ~Smoother() = default;

  /// Improve A x = b on the own rows: before the correction by a coarser level from zero, after it from x, by
  /// the adjoint of what was done before, so that the cycle is symmetric.
  virtual void smooth(double *x, const double *b, bool starts_from_zero) const = 0;
};

} // namespace dovetail
