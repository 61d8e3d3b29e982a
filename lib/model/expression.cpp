#include "lib/model/expression.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "lib/model/error.h"

namespace lanc {

/// Recursive descent over: sum = product {(+|−) product}; product = factor {(*|/) factor};
/// factor = (+|−) factor | atom [^ factor]; atom = number | t | pi | name(sum) | (sum).
class Expression::Parser {
 public:
  Parser(std::string_view text, std::vector<Step>& steps) : text_(text), steps_(steps) {
    constexpr std::size_t longest = 4096;
    if (text.size() > longest) fail(longest, "the formula is longer than 4096 characters");
    sum();
    skip_space();
    if (at_ != text_.size()) fail(at_, fmt::format("unexpected '{}'", text_[at_]));
  }

 private:
  [[noreturn]] void fail(std::size_t at, const std::string& what) const {
    throw InputError(
        fmt::format("formula, character {}: {}; a formula is made of numbers, t, pi, + - * / ^ ( ) and "
                    "sin cos tan asin acos atan exp log sqrt abs tanh",
                    at + 1, what));
  }
  void skip_space() {
    while (at_ < text_.size() && (text_[at_] == ' ' || text_[at_] == '\t')) ++at_;
  }
  bool accept(char c) {
    skip_space();
    if (at_ == text_.size() || text_[at_] != c) return false;
    ++at_;
    return true;
  }
  void sum() {
    product();
    for (;;) {
      if (accept('+'))
        product(), steps_.push_back({Code::add});
      else if (accept('-'))
        product(), steps_.push_back({Code::subtract});
      else
        return;
    }
  }
  void product() {
    factor();
    for (;;) {
      if (accept('*'))
        factor(), steps_.push_back({Code::multiply});
      else if (accept('/'))
        factor(), steps_.push_back({Code::divide});
      else
        return;
    }
  }
  void factor() {
    constexpr int deepest = 200;
    if (++nesting_ > deepest) fail(at_, "more than 200 levels of nesting");
    if (accept('-')) {
      factor();
      steps_.push_back({Code::negate});
    } else if (accept('+')) {
      factor();
    } else {
      atom();
      if (accept('^')) power();
    }
    --nesting_;
  }
  void power() {
    const std::size_t start = steps_.size(), where = at_;
    factor();
    for (std::size_t k = start; k < steps_.size(); ++k)
      if (steps_[k].code == Code::time) fail(where, "the exponent depends on t; write exp(y*log(x)) for x^y");
    steps_.push_back({Code::power});
  }
  void atom() {
    skip_space();
    if (at_ == text_.size()) fail(at_, "the formula ends where a value is expected");
    const char c = text_[at_];
    if (c == '(') {
      ++at_;
      sum();
      close();
    } else if ((c >= '0' && c <= '9') || c == '.') {
      double value = 0;
      const auto [end, error] = std::from_chars(text_.data() + at_, text_.data() + text_.size(), value);
      if (error != std::errc()) fail(at_, "not a number a double can hold");
      at_ = static_cast<std::size_t>(end - text_.data());
      steps_.push_back({Code::number, value});
    } else {
      name();
    }
  }
  void name() {
    const std::size_t start = at_;
    while (at_ < text_.size() && text_[at_] >= 'a' && text_[at_] <= 'z') ++at_;
    const std::string_view word = text_.substr(start, at_ - start);
    if (word == "t") return steps_.push_back({Code::time});
    if (word == "pi") return steps_.push_back({Code::number, std::numbers::pi});
    static constexpr std::pair<std::string_view, Code> functions[] = {
        {"sin", Code::sin},   {"cos", Code::cos},   {"tan", Code::tan},  {"asin", Code::asin},
        {"acos", Code::acos}, {"atan", Code::atan}, {"exp", Code::exp},  {"log", Code::log},
        {"sqrt", Code::sqrt}, {"abs", Code::abs},   {"tanh", Code::tanh}};
    for (const auto& [known, code] : functions) {
      if (word != known) continue;
      if (!accept('(')) fail(at_, fmt::format("'{}' needs its argument in parentheses", word));
      sum();
      close();
      return steps_.push_back({code});
    }
    if (word.empty()) fail(start, fmt::format("unexpected '{}'", text_[start]));
    fail(start, fmt::format("unknown name '{}'", word));
  }
  void close() {
    if (!accept(')')) fail(at_, "a closing parenthesis is missing");
  }

  std::string_view text_;
  std::vector<Step>& steps_;
  std::size_t at_ = 0;
  int nesting_ = 0;
};

Expression::Expression(std::string_view text) {
  Parser(text, steps_);
  int depth = 0;
  for (const Step& step : steps_) {
    if (step.code <= Code::time)
      depth_ = std::max(depth_, ++depth);
    else if (step.code <= Code::power)
      --depth;
  }
}

namespace {

/// f(x(t)) by the chain rule, from f, f' and f'' at x.
MotionSample chain(const MotionSample& x, double f, double df, double ddf) {
  return {f, df * x.velocity, ddf * x.velocity * x.velocity + df * x.acceleration};
}

MotionSample multiply(const MotionSample& a, const MotionSample& b) {
  return {a.position * b.position, a.velocity * b.position + a.position * b.velocity,
          a.acceleration * b.position + 2 * a.velocity * b.velocity + a.position * b.acceleration};
}

/// x^n; whole n by its own rule, so that 0^2 has derivatives and (−1)^3 a value.
MotionSample raise(const MotionSample& x, double n) {
  const double first = n == 0 ? 0 : n * std::pow(x.position, n - 1);
  const double second = n == 0 || n == 1 ? 0 : n * (n - 1) * std::pow(x.position, n - 2);
  return chain(x, std::pow(x.position, n), first, second);
}

}  // namespace

MotionSample Expression::at(double t) const {
  std::vector<MotionSample> stack;
  stack.reserve(depth_);
  for (const Step& step : steps_) {
    if (step.code == Code::number) {
      stack.push_back({step.number, 0, 0});
      continue;
    }
    if (step.code == Code::time) {
      stack.push_back({t, 1, 0});
      continue;
    }
    MotionSample b = stack.back();
    if (step.code <= Code::power) {
      stack.pop_back();
      MotionSample& a = stack.back();
      switch (step.code) {
        case Code::add: a = {a.position + b.position, a.velocity + b.velocity, a.acceleration + b.acceleration}; break;
        case Code::subtract:
          a = {a.position - b.position, a.velocity - b.velocity, a.acceleration - b.acceleration};
          break;
        case Code::multiply: a = multiply(a, b); break;
        case Code::divide: a = multiply(a, raise(b, -1)); break;
        default: a = raise(a, b.position);
      }
      continue;
    }
    const double x = b.position;
    MotionSample& top = stack.back();
    switch (step.code) {
      case Code::negate: top = {-x, -b.velocity, -b.acceleration}; break;
      case Code::sin: top = chain(b, std::sin(x), std::cos(x), -std::sin(x)); break;
      case Code::cos: top = chain(b, std::cos(x), -std::sin(x), -std::cos(x)); break;
      case Code::tan: {
        const double y = std::tan(x), d = 1 + y * y;
        top = chain(b, y, d, 2 * y * d);
        break;
      }
      case Code::asin:
      case Code::acos: {
        const double sign = step.code == Code::asin ? 1 : -1, square = 1 - x * x, d = sign / std::sqrt(square);
        top = chain(b, sign > 0 ? std::asin(x) : std::acos(x), d, x * d / square);
        break;
      }
      case Code::atan: {
        const double d = 1 / (1 + x * x);
        top = chain(b, std::atan(x), d, -2 * x * d * d);
        break;
      }
      case Code::exp: top = chain(b, std::exp(x), std::exp(x), std::exp(x)); break;
      case Code::log: top = chain(b, std::log(x), 1 / x, -1 / (x * x)); break;
      case Code::sqrt: top = chain(b, std::sqrt(x), 0.5 / std::sqrt(x), -0.25 / (x * std::sqrt(x))); break;
      case Code::abs:
        top = chain(b, std::abs(x), x > 0 ? 1 : x < 0 ? -1 : std::numeric_limits<double>::quiet_NaN(), 0);
        break;
      default: {
        const double y = std::tanh(x), d = 1 - y * y;
        top = chain(b, y, d, -2 * y * d);
      }
    }
  }
  return stack.back();
}

}  // namespace lanc
