// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// What a smoother divides by.

#pragma once

namespace dovetail {

/// z = M^-1 r, where M approximates a symmetric positive definite matrix A.
class Approximation
{
public:
  virtual ~Approximation() = default;
  /// On the own rows. z may be r.
  virtual void vmult(double *z, const double *r) const = 0;
};

} // namespace dovetail
