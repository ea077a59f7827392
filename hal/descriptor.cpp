#include "hal/descriptor.h"

#include <utility>

#include <unistd.h>

namespace cheval::hal {

Descriptor& Descriptor::operator=(Descriptor&& other) noexcept {
    if (this != &other) {
        reset();
        value_ = other.release();
    }
    return *this;
}

int Descriptor::release() {
    return std::exchange(value_, -1);
}

void Descriptor::reset() {
    if (value_ >= 0) ::close(value_);
    value_ = -1;
}

}  // namespace cheval::hal
