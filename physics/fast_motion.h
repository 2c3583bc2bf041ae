// What is faster than the steps through time, carried through them by itself: oil springs, and the joints' own losses
// beside them.
//
// Between two samples a cylinder's oil may ring many times against the arm, and pressures settle in less than a step.
// Both are all but linear, as are losses in proportion to speed, which a light wrist turns into a fast decay. With d
// the departure of the plant's state from where a step begins, the rates are
//   d' = L d + N(d, t):
// L is that linear part, kept over a step, and N all the rest, slow. Krogstad's fourth-order method evaluates the whole
// plant where Kutta's does, as often, and carries L by itself in between; where L = 0 it is Kutta's (S. Krogstad, J.
// Comput. Phys. 203 (2005), ETDRK4-B). A stiff L leaves it third order, and Cox and Matthews' scheme second (M.
// Hochbruck, A. Ostermann, SIAM J. Numer. Anal. 43 (2005)). L couples all joints: an effort on one accelerates every
// other through the arm's inertia,
//   q' = v,   v' = M^-1 ((dtau/dz) z - D v),   z' = (dz'/dv) v + (dz'/dz) z   (departures).
// L need not be exact: what it leaves out is in N, at the order of the method.
#pragma once

#include <algorithm>
#include <array>
#include <vector>

#include "physics/component.h"

namespace lacuna {

template <class T>
class FastMotion {
 public:
  using State = std::vector<T>;  ///< q, v, then the plant's other states

  FastMotion(std::size_t joints, std::size_t size)
      : n_(joints), size_(size), effort_(n_, T(0.0)), pivot_(n_, T(0.0)), column_(n_, T(0.0)) {
    for (State* w : {&d_, &n2_, &n3_, &n4_, &stage_, &still_, &slope_, &bend_, &rate_, &next_, &before_})
      w->assign(size_, T(0.0));
    for (State* w : {&inverse_, &factor_, &effective_}) w->assign(n_ * n_, T(0.0));
  }

  struct Spring {
    int joint;
    std::size_t state;  ///< where its two states begin
    FastPart<T> part;
  };
  struct Loss {
    int joint;
    T size;  ///< N m s/rad (N s/m)
  };
  void add_spring(int joint, std::size_t state) {
    springs_.push_back({joint, state, {}});
    pull(joint);
  }
  void add_loss(int joint) {
    losses_.push_back({joint, T(0.0)});
    pull(joint);
  }
  /// Losses alone are no reason: what each step costs more than Kutta's, it is not longer.
  bool none() const { return springs_.empty(); }
  /// Either to be brought up to date before every step; then set_free().
  std::vector<Spring>& springs() { return springs_; }
  std::vector<Loss>& losses() { return losses_; }

  /// The arm's inertia, row by row, kg m^2 (kg m, kg), for the steps that follow.
  void set_inertia(const std::vector<T>& mass) {
    factorise(mass);
    for (std::size_t column = 0; column < n_; ++column) solve_unit(column);
  }
  /// Which joints are free (1) or held (0) over the next step.
  void set_free(const std::vector<T>& free) {
    effective_ = inverse_;
    for (std::size_t j = 0; j < n_; ++j) {
      const Mask<T> held = free[j] == T(0.0);
      if (any(held)) hold(j, held);
    }
    measure();
  }

  /// to = x after a step of h (s). k1: rates at x; rates(since, at, out) evaluates them `since` the start of the step,
  /// in turn for k2 and k3 in the middle and k4 at the end.
  template <class Rates>
  void step(const State& x, const T& h, const State& k1, State& k2, State& k3, State& k4, State& to,
            const Rates& rates) {
    const T half = T(0.5) * h;
    const T per = select(h > T(0.0), T(1.0) / max(h, T(1e-300)), T(0.0));
    begin(d_);
    carry(d_, k1, still_, still_, half);
    rates(half, moved(x, d_), k2);
    remainder(d_, k2, n2_);
    for (std::size_t i = 0; i < size_; ++i) slope_[i] = T(4.0) * per * (n2_[i] - k1[i]);
    begin(d_);
    carry(d_, k1, slope_, still_, half);
    rates(half, moved(x, d_), k3);
    remainder(d_, k3, n3_);
    for (std::size_t i = 0; i < size_; ++i) slope_[i] = T(2.0) * per * (n3_[i] - k1[i]);
    begin(d_);
    carry(d_, k1, slope_, still_, h);
    rates(h, moved(x, d_), k4);
    remainder(d_, k4, n4_);
    for (std::size_t i = 0; i < size_; ++i) {  // the parabola of N over the step
      const T middle = n2_[i] + n3_[i];
      slope_[i] = per * (T(2.0) * middle - T(3.0) * k1[i] - n4_[i]);
      bend_[i] = per * per * T(2.0) * (k1[i] - middle + n4_[i]);
    }
    begin(d_);
    carry(d_, k1, slope_, bend_, h);
    for (std::size_t i = 0; i < size_; ++i) to[i] = x[i] + d_[i];
  }

 private:
  static constexpr int kTerms = 8;            ///< of the exponential's series
  static constexpr double kPiece = 1.6;       ///< rad in a piece: 1.6^9 / 9! = 2e-4 of the fast motion is left out
  static constexpr double kMostPieces = 256;  ///< of a step: what is faster yet diverges
  static constexpr double kHopeless = 1e6;    ///< what has diverged, or is not a number, gets one piece: it is lost

  static void begin(State& d) { std::fill(d.begin(), d.end(), T(0.0)); }
  const State& moved(const State& x, const State& d) {
    for (std::size_t i = 0; i < size_; ++i) stage_[i] = x[i] + d[i];
    return stage_;
  }
  void pull(int joint) {
    if (std::ranges::find(pulled_, joint) == pulled_.end()) pulled_.push_back(joint);
  }
  /// N = k - L d.
  void remainder(const State& d, const State& k, State& out) {
    apply(d, out);
    for (std::size_t i = 0; i < size_; ++i) out[i] = k[i] - out[i];
  }

  /// out = L d.
  void apply(const State& d, State& out) {
    std::fill(out.begin() + static_cast<std::ptrdiff_t>(n_), out.end(), T(0.0));
    for (std::size_t j = 0; j < n_; ++j) out[j] = d[n_ + j];
    for (const std::size_t j : pulled_) effort_[j] = T(0.0);
    for (const Loss& loss : losses_) {
      const std::size_t j = loss.joint;
      effort_[j] = T(0.0) - loss.size * d[n_ + j];
    }
    for (const Spring& s : springs_) {
      const std::size_t j = s.joint;
      const T speed = d[n_ + j], a = d[s.state], b = d[s.state + 1];
      effort_[j] = effort_[j] + s.part.effort[0] * a + s.part.effort[1] * b;
      out[s.state] = s.part.from_speed[0] * speed + s.part.among[0] * a + s.part.among[1] * b;
      out[s.state + 1] = s.part.from_speed[1] * speed + s.part.among[2] * a + s.part.among[3] * b;
    }
    for (const std::size_t j : pulled_) {
      for (std::size_t i = 0; i < n_; ++i) out[n_ + i] = out[n_ + i] + effective_[i * n_ + j] * effort_[j];
    }
  }

  /// d after `time` (s) of d' = L d + g0 + g1 t + g2 t^2.
  void carry(State& d, const State& g0, const State& g1, const State& g2, const T& time) {
    const T wanted = floor(time * fastest_ * T(1.0 / kPiece)) + T(1.0);
    const T pieces = select(wanted < T(kHopeless), min(wanted, T(kMostPieces)), T(1.0));
    const T piece = time / pieces;
    for (T done(0.0); any(done < pieces); done = done + T(1.0)) {
      // Lanes that need fewer pieces than others stand still, to the bit.
      const Mask<T> going = done < pieces;
      const bool together = all(going);
      if (!together) before_ = d;
      carry_piece(d, g0, g1, g2, done * piece, piece);
      if (together) continue;
      for (std::size_t i = 0; i < size_; ++i) d[i] = select(going, d[i], before_[i]);
    }
  }

  /// One piece by Taylor's series, `from` (s) after the start of the forcing.
  void carry_piece(State& d, const State& g0, const State& g1, const State& g2, const T& from, const T& h) {
    apply(d, rate_);
    for (std::size_t i = 0; i < size_; ++i) rate_[i] = rate_[i] + g0[i] + from * (g1[i] + from * g2[i]);
    T factor = h;
    for (int k = 1;; ++k) {
      for (std::size_t i = 0; i < size_; ++i) d[i] = d[i] + factor * rate_[i];
      if (k == kTerms) return;
      apply(rate_, next_);
      if (k == 1)
        for (std::size_t i = 0; i < size_; ++i) next_[i] = next_[i] + g1[i] + T(2.0) * from * g2[i];
      if (k == 2)
        for (std::size_t i = 0; i < size_; ++i) next_[i] = next_[i] + T(2.0) * g2[i];
      rate_.swap(next_);
      factor = factor * h * T(1.0 / (k + 1));
    }
  }

  /// Cholesky's factor, and one over its diagonal.
  void factorise(const std::vector<T>& mass) {
    for (std::size_t i = 0; i < n_; ++i) {
      for (std::size_t j = 0; j <= i; ++j) {
        T sum = mass[i * n_ + j];
        for (std::size_t k = 0; k < j; ++k) sum = sum - factor_[i * n_ + k] * factor_[j * n_ + k];
        if (i == j) pivot_[i] = T(1.0) / sqrt(sum);
        factor_[i * n_ + j] = sum * pivot_[j];
      }
    }
  }
  /// Column of the inverse, through both triangles.
  void solve_unit(std::size_t column) {
    for (std::size_t i = 0; i < n_; ++i) {
      T sum(i == column ? 1.0 : 0.0);
      for (std::size_t k = 0; k < i; ++k) sum = sum - factor_[i * n_ + k] * column_[k];
      column_[i] = sum * pivot_[i];
    }
    for (std::size_t i = n_; i-- > 0;) {
      T sum = column_[i];
      for (std::size_t k = i + 1; k < n_; ++k) sum = sum - factor_[k * n_ + i] * inverse_[k * n_ + column];
      inverse_[i * n_ + column] = sum * pivot_[i];
    }
  }
  /// What is left of the inverse when joint j cannot move: Schur's complement.
  void hold(std::size_t j, const Mask<T>& held) {
    const T pivot = effective_[j * n_ + j];
    for (std::size_t i = 0; i < n_; ++i) column_[i] = select(held, effective_[i * n_ + j] / pivot, T(0.0));
    const auto begin = effective_.begin() + static_cast<std::ptrdiff_t>(j * n_);
    const std::vector<T> row(begin, begin + static_cast<std::ptrdiff_t>(n_));
    for (std::size_t i = 0; i < n_; ++i)
      for (std::size_t k = 0; k < n_; ++k) effective_[i * n_ + k] = effective_[i * n_ + k] - column_[i] * row[k];
  }
  /// fastest_: no mode is faster. The squares of the springs' frequencies add up to a trace, which bounds each mode's;
  /// what losses make of the inertia's inverse is bounded by its Frobenius norm, once it is made symmetric.
  void measure() {
    T squares(0.0), fading(0.0), lost(0.0);
    for (const Loss& a : losses_) {
      for (const Loss& b : losses_) {
        const T& w = effective_[static_cast<std::size_t>(a.joint) * n_ + b.joint];
        lost = lost + a.size * b.size * w * w;
      }
    }
    for (const Spring& s : springs_) {
      const std::size_t j = s.joint;
      const FastPart<T>& p = s.part;
      squares = squares + abs(effective_[j * n_ + j] * (p.effort[0] * p.from_speed[0] + p.effort[1] * p.from_speed[1]));
      fading = max(fading, max(abs(p.among[0]) + abs(p.among[1]), abs(p.among[2]) + abs(p.among[3])));
    }
    fastest_ = sqrt(squares) + sqrt(lost) + fading;
  }

  std::size_t n_, size_;
  std::vector<Spring> springs_;
  std::vector<Loss> losses_;
  std::vector<std::size_t> pulled_;     ///< joints that either acts on
  State effort_;                        ///< N m (N), of both on each joint
  State inverse_, factor_, effective_;  ///< n x n; the inverses in 1/(kg m^2), the second with held joints taken out
  State pivot_, column_;
  State d_, n2_, n3_, n4_, stage_, still_, slope_, bend_;  ///< of a step
  State rate_, next_, before_;                             ///< of a piece
  T fastest_ = T(0.0);                                     ///< rad/s
};

}  // namespace lacuna
