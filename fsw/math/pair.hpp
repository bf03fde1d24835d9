#pragma once

namespace relnav {

/// Two numbers that are worked on alike, lane by lane.
template <typename S>
class Pair {
 public:
  Pair() = default;
  Pair(const S& first, const S& second) : first_(first), second_(second) {}
  [[nodiscard]] const S& first() const { return first_; }
  [[nodiscard]] const S& second() const { return second_; }

  Pair& operator+=(const Pair& b) { return *this = *this + b; }
  friend Pair operator+(const Pair& a, const Pair& b) { return {a.first_ + b.first_, a.second_ + b.second_}; }
  friend Pair operator-(const Pair& a, const Pair& b) { return {a.first_ - b.first_, a.second_ - b.second_}; }
  friend Pair operator*(const Pair& a, const Pair& b) { return {a.first_ * b.first_, a.second_ * b.second_}; }
  friend Pair operator*(const Pair& a, const S& b) { return {a.first_ * b, a.second_ * b}; }

 private:
  S first_{0};
  S second_{0};
};

/// In one register of two lanes where the processor has such; IEEE's operations go lane by lane, the bits are the same.
template <>
class Pair<double> {
 public:
  Pair() = default;
  Pair(double first, double second) : lanes_{first, second} {}
  [[nodiscard]] double first() const { return lanes_[0]; }
  [[nodiscard]] double second() const { return lanes_[1]; }

  Pair& operator+=(const Pair& b) { return *this = *this + b; }
  friend Pair operator+(const Pair& a, const Pair& b) { return Pair(a.lanes_ + b.lanes_); }
  friend Pair operator-(const Pair& a, const Pair& b) { return Pair(a.lanes_ - b.lanes_); }
  friend Pair operator*(const Pair& a, const Pair& b) { return Pair(a.lanes_ * b.lanes_); }
  friend Pair operator*(const Pair& a, double b) { return Pair(a.lanes_ * b); }

 private:
  using Lanes = double __attribute__((vector_size(16)));
  explicit Pair(const Lanes& lanes) : lanes_(lanes) {}
  Lanes lanes_{};
};

}  // namespace relnav
