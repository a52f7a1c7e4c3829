// SPDX-License-Identifier: Apache-2.0
#include "support/adding_doubling.h"

#include <cmath>

namespace brume::test {

namespace {

constexpr double kPiDouble = 3.14159265358979323846;

/// A square matrix of doubles.
struct Matrix {
  std::size_t n;
  std::vector<double> a;
  explicit Matrix(std::size_t size) : n(size), a(size * size, 0.0) {}
  double& operator()(std::size_t i, std::size_t j) { return a[i * n + j]; }
  double operator()(std::size_t i, std::size_t j) const { return a[i * n + j]; }
};

Matrix operator*(const Matrix& x, const Matrix& y) {
  Matrix r(x.n);
  for (std::size_t i = 0; i < x.n; ++i)
    for (std::size_t k = 0; k < x.n; ++k)
      for (std::size_t j = 0; j < x.n; ++j) r(i, j) += x(i, k) * y(k, j);
  return r;
}

/// (1 - m)^-1 by Gauss-Jordan elimination with partial pivoting.
Matrix inverseOfOneMinus(const Matrix& m) {
  const std::size_t n = m.n;
  Matrix a(n), inverse(n);
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t j = 0; j < n; ++j) a(i, j) = (i == j ? 1.0 : 0.0) - m(i, j);
    inverse(i, i) = 1;
  }
  for (std::size_t c = 0; c < n; ++c) {
    std::size_t pivot = c;
    for (std::size_t r = c + 1; r < n; ++r)
      if (std::abs(a(r, c)) > std::abs(a(pivot, c))) pivot = r;
    for (std::size_t j = 0; j < n; ++j) {
      std::swap(a(c, j), a(pivot, j));
      std::swap(inverse(c, j), inverse(pivot, j));
    }
    const double scale = 1 / a(c, c);
    for (std::size_t j = 0; j < n; ++j) {
      a(c, j) *= scale;
      inverse(c, j) *= scale;
    }
    for (std::size_t r = 0; r < n; ++r) {
      const double factor = a(r, c);
      if (r == c || factor == 0) continue;
      for (std::size_t j = 0; j < n; ++j) {
        a(r, j) -= factor * a(c, j);
        inverse(r, j) -= factor * inverse(c, j);
      }
    }
  }
  return inverse;
}

struct Quadrature {
  std::vector<double> mu, weight;  // on (0, 1)
};

/// Gauss-Legendre nodes by Newton's method on the Legendre polynomial.
Quadrature gaussLegendre(int n) {
  Quadrature q;
  for (int i = 0; i < n; ++i) {
    double x = std::cos(kPiDouble * (i + 0.75) / (n + 0.5)), derivative = 1;
    for (int step = 0; step < 100; ++step) {
      double p0 = 1, p1 = x;
      for (int k = 2; k <= n; ++k) {
        const double p2 = ((2 * k - 1) * x * p1 - (k - 1) * p0) / k;
        p0 = p1;
        p1 = p2;
      }
      derivative = n * (x * p1 - p0) / (x * x - 1);
      const double change = p1 / derivative;
      x -= change;
      if (std::abs(change) < 1e-15) break;
    }
    q.mu.push_back(0.5 * (x + 1));
    q.weight.push_back(1 / ((1 - x * x) * derivative * derivative));
  }
  return q;
}

/// Operators of a slab on the fluxes in the quadrature's directions, out_i = sum_j M(i, j) in_j;
/// the asked angles come last and carry no weight.
struct SlabOperators {
  Quadrature q;
  Matrix R, T;                 // T without the unscattered light
  std::vector<double> direct;  // unscattered share
};

SlabOperators thinLayer(double albedo, double thickness, const AveragedPhase& phase, Quadrature q) {
  const std::size_t n = q.mu.size();
  SlabOperators s{std::move(q), Matrix(n), Matrix(n), std::vector<double>(n)};
  for (std::size_t j = 0; j < n; ++j) {
    std::vector<double> forward(n), backward(n);
    double total = 0;
    for (std::size_t i = 0; i < n; ++i) {
      forward[i] = phase(s.q.mu[i], s.q.mu[j]);
      backward[i] = phase(-s.q.mu[i], s.q.mu[j]);
      total += s.q.weight[i] * (forward[i] + backward[i]);
    }
    // Of a flux mu_j in direction j the layer scatters albedo thickness / mu_j; the discrete phase
    // function is normalised exactly.
    for (std::size_t i = 0; i < n; ++i) {
      const double scattered = albedo * thickness / s.q.mu[j] * s.q.weight[i] / total;
      s.R(i, j) = scattered * backward[i];
      s.T(i, j) = scattered * forward[i];
    }
    s.direct[j] = std::exp(-thickness / s.q.mu[j]);
  }
  return s;
}

/// Two equal layers: light between them goes back and forth, summed by (1 - R R)^-1.
void doubleSlab(SlabOperators& s) {
  const std::size_t n = s.q.mu.size();
  Matrix between = inverseOfOneMinus(s.R * s.R);
  Matrix through = s.T;
  for (std::size_t i = 0; i < n; ++i) through(i, i) += s.direct[i];
  const Matrix down = between * through;  // flux going down at the interface
  Matrix up = s.R * down;                 // and up
  Matrix newR = through * up, newT = through * down;
  for (std::size_t i = 0; i < n; ++i) {
    s.direct[i] *= s.direct[i];
    newT(i, i) -= s.direct[i];
  }
  for (std::size_t i = 0; i < n * n; ++i) newR.a[i] += s.R.a[i];
  s.R = newR;
  s.T = newT;
}

SlabOperators solve(double albedo, double opticalThickness, const AveragedPhase& phase,
                    const std::vector<double>& mus, int nodes) {
  Quadrature q = gaussLegendre(nodes);
  for (double mu : mus) {
    q.mu.push_back(mu);
    q.weight.push_back(0);
  }
  // From a layer so thin that it scatters once.
  constexpr int kDoublings = 30;
  SlabOperators s =
      thinLayer(albedo, opticalThickness / std::ldexp(1.0, kDoublings), phase, std::move(q));
  for (int step = 0; step < kDoublings; ++step) doubleSlab(s);
  return s;
}

}  // namespace

AveragedPhase averaged(AnglePhase phase) {
  return [phase = std::move(phase)](double mu, double muPrime) {
    constexpr int kSteps = 2048;
    const double s = std::sqrt((1 - mu * mu) * (1 - muPrime * muPrime));
    double sum = 0;
    for (int i = 0; i < kSteps; ++i)
      sum += phase(mu * muPrime + s * std::cos(kPiDouble * (i + 0.5) / kSteps));
    return sum / kSteps;
  };
}

AnglePhase henyeyGreensteinOf(double g) {
  return [g](double c) { return (1 - g * g) / std::pow(1 + g * g - 2 * g * c, 1.5); };
}

std::vector<SlabRadiance> solveSlab(double albedo, double opticalThickness,
                                    const AveragedPhase& phase, const std::vector<double>& mus,
                                    int nodes) {
  const SlabOperators slab = solve(albedo, opticalThickness, phase, mus, nodes);
  // A unit flux from angle j leaves in total R on its side, T on the other; by reciprocity that is
  // the radiance seen at j.
  std::vector<SlabRadiance> result;
  const std::size_t n = slab.q.mu.size();
  for (std::size_t j = static_cast<std::size_t>(nodes); j < n; ++j) {
    SlabRadiance s;
    for (std::size_t i = 0; i < n; ++i) {
      s.R += slab.R(i, j);
      s.T += slab.T(i, j);
    }
    // The asked angles carry no weight of their own but their own column holds the unscattered
    // light.
    s.T += slab.direct[j];
    result.push_back(s);
  }
  return result;
}

std::vector<SlabInBeam> solveSlabInBeams(double albedo, double opticalThickness,
                                         const AveragedPhase& phase, int nodes) {
  const SlabOperators slab = solve(albedo, opticalThickness, phase, {1}, nodes);
  // A unit flux that falls on the slab along its normal gives the radiance M(i, normal) / (2 pi w_i
  // mu_i) at node i; by reciprocity the same is seen along the normal when that flux comes from
  // node i, where it is mu_i per irradiance across the beam.
  const std::size_t normal = static_cast<std::size_t>(nodes);
  std::vector<SlabInBeam> result;
  for (std::size_t i = 0; i < normal; ++i) {
    const double scale = 1 / (2 * kPiDouble * slab.q.weight[i]);
    result.push_back({slab.q.mu[i], slab.R(i, normal) * scale, slab.T(i, normal) * scale});
  }
  return result;
}

}  // namespace brume::test
