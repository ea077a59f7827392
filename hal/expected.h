// Errors as values. Every fallible call at a room's border returns Expected<T>; an Error says what happened (cause),
// what to do about it (mend) and what it follows from (why), with file, line and key where there are any.
#pragma once

#include <cassert>
#include <string>
#include <string_view>
#include <utility>
#include <variant>

namespace cheval {

/// What kind of failure it is, for code that must act on it; people read the texts.
enum class ErrorCode {
    invalidInput,  ///< A file, setting, frame or argument that is refused.
    notFound,      ///< Something named does not exist.
    unavailable,   ///< A device or service is absent, busy or lost; trying again may help.
    conflict,      ///< Another program holds what is needed, and trying again does not help while it runs.
    timedOut,      ///< A limit on time was reached.
    resource,      ///< Memory, descriptors or disk ran out.
    internal,      ///< A fault of ours.
};

/// An error on its way up. Thread-bound value.
struct Error {
    ErrorCode code = ErrorCode::internal;
    std::string cause;  ///< What happened, in one sentence, e.g. "the outer cage has 1042 vertices".
    std::string mend;   ///< What a technician can do about it; may be empty.
    std::string why;    ///< The rule or circumstance behind it; may be empty.
    std::string file;   ///< The file at fault; empty where there is none.
    int line = 0;       ///< Line in that file, from 1; 0 where there is none.
    std::string key;    ///< Setting, node or field at fault; may be empty.

    /// Adds what was being attempted, outermost first: "while loading the wardrobe: …".
    Error&& within(std::string_view attempt) && {
        cause = std::string(attempt) + ": " + cause;
        return std::move(*this);
    }
    /// "file:line: key: cause. Mend: …. Why: …." in one line, leaving out what is empty.
    [[nodiscard]] std::string message() const;
};

/// Either a T or an Error. Accessing the wrong one is a programming error and asserts.
template <typename T>
class [[nodiscard]] Expected {
  public:
    Expected(T value) : state_(std::in_place_index<0>, std::move(value)) {}
    Expected(Error error) : state_(std::in_place_index<1>, std::move(error)) {}

    [[nodiscard]] bool hasValue() const { return state_.index() == 0; }
    explicit operator bool() const { return hasValue(); }

    T& value() & {
        assert(hasValue());
        return *std::get_if<0>(&state_);
    }
    const T& value() const& {
        assert(hasValue());
        return *std::get_if<0>(&state_);
    }
    T&& value() && {
        assert(hasValue());
        return std::move(*std::get_if<0>(&state_));
    }
    T& operator*() & { return value(); }
    const T& operator*() const& { return value(); }
    T&& operator*() && { return std::move(*this).value(); }
    T* operator->() { return &value(); }
    const T* operator->() const { return &value(); }

    Error& error() & {
        assert(!hasValue());
        return *std::get_if<1>(&state_);
    }
    const Error& error() const& {
        assert(!hasValue());
        return *std::get_if<1>(&state_);
    }
    Error&& error() && {
        assert(!hasValue());
        return std::move(*std::get_if<1>(&state_));
    }

  private:
    std::variant<T, Error> state_;
};

/// Success without a value, or an Error.
template <>
class [[nodiscard]] Expected<void> {
  public:
    Expected() = default;
    Expected(Error error) : error_(std::in_place_index<1>, std::move(error)) {}

    [[nodiscard]] bool hasValue() const { return error_.index() == 0; }
    explicit operator bool() const { return hasValue(); }

    Error& error() & {
        assert(!hasValue());
        return *std::get_if<1>(&error_);
    }
    const Error& error() const& {
        assert(!hasValue());
        return *std::get_if<1>(&error_);
    }
    Error&& error() && {
        assert(!hasValue());
        return std::move(*std::get_if<1>(&error_));
    }

  private:
    std::variant<std::monostate, Error> error_;
};

}  // namespace cheval
