#!/usr/bin/env python3
"""Reads systemd/60-cheval.rules as udev(7) does, for the few keys that it uses, and plays devices through it.

    udev_rules_test.py RULES

Passes when every line is one that udev would understand, each sensor that Cheval knows gets its group, mode, name and no
sleep, and no other device gets anything. (udevadm verify came with a later systemd than Debian 12 has.)
"""
import fnmatch
import re
import sys
import unittest

# What the README promises: vendor, product.
SENSORS = [("1d27", product) for product in ("0500", "0600", "0601", "0609", "1250", "1260", "1270", "1280", "1290", "f9db")]
SENSORS += [("045e", "02ae"), ("045e", "02bf"), ("2bc5", "0401"), ("2bc5", "04ff"), ("2bc5", "060b")]
# A reader of the same vendors' other things, a sensor's audio part, a keyboard, a hub.
OTHERS = [("1d27", "0200"), ("045e", "02ad"), ("045e", "07f8"), ("2bc5", "0501"), ("2bc5", "04000"), ("046d", "c31c"), ("1d6b", "0002")]

TOKEN = re.compile(r'\s*([A-Z]+)(?:\{([^}]+)\})?\s*(==|!=|\+=|-=|:=|=)\s*"([^"]*)"\s*(?:,|$)')
MATCHES = {"ACTION", "SUBSYSTEM", "KERNEL", "ENV", "ATTR", "TEST"}
ASSIGNMENTS = {"GROUP", "MODE", "ENV", "ATTR", "TAG", "SYMLINK", "GOTO", "LABEL"}


def parse(text):
    """Rules, each a list of (key, attribute, operator, value); raises ValueError with the line at fault."""
    rules = []
    for number, line in enumerate(text.splitlines(), 1):
        line = line.strip()
        if not line or line.startswith("#"):
            continue
        rule, place = [], 0
        while place < len(line):
            token = TOKEN.match(line, place)
            if not token:
                raise ValueError(f"line {number}: {line[place:]!r} is no KEY, operator and quoted value")
            key, _, operator, _ = token.groups()
            if key not in (MATCHES if operator in ("==", "!=") else ASSIGNMENTS):
                raise ValueError(f"line {number}: {key} {operator} is not understood")
            rule.append(token.groups())
            place = token.end()
        rules.append(rule)
    labels = [value for rule in rules for key, _, _, value in rule if key == "LABEL"]
    for rule in rules:
        for key, _, _, value in rule:
            if key == "GOTO" and value not in labels:
                raise ValueError(f"there is no LABEL {value!r} to go to")
    return rules


def matches(pattern, value):
    return any(fnmatch.fnmatchcase(value, one) for one in pattern.split("|"))


def play(rules, device):
    """What the rules give a device: a dictionary of the keys that they assign; lists for those that are added to."""
    env = dict(device.get("env", {}))
    given, final, goto = {}, set(), None
    for rule in rules:
        if goto is not None:
            if ("LABEL", None, "=", goto) not in rule:
                continue
            goto = None
        for key, attribute, operator, value in rule:
            if operator in ("==", "!="):
                if key == "TEST":
                    holds = value in device.get("attr", {})
                elif key == "ATTR":
                    holds = attribute in device.get("attr", {}) and matches(value, device["attr"][attribute])
                else:
                    holds = matches(value, env.get(attribute, "") if key == "ENV" else device[key.lower()])
                if holds != (operator == "=="):
                    break
            elif key == "GOTO":
                goto = value
            elif key == "ENV":
                env[attribute] = value
            elif key != "LABEL":
                name = key if attribute is None else f"{key}{{{attribute}}}"
                if operator == "+=":
                    given.setdefault(name, []).append(value)
                elif name not in final:
                    given[name] = value
                if operator == ":=":
                    final.add(name)
    return given, final


def usb(vendor, product, devtype="usb_device", action="add"):
    return {"action": action, "subsystem": "usb", "kernel": "1-2", "env": {"DEVTYPE": devtype},
            "attr": {"idVendor": vendor, "idProduct": product, "power/control": "auto"}}


class Rules(unittest.TestCase):
    def setUp(self):
        with open(RULES, encoding="utf-8") as file:
            self.text = file.read()
        self.rules = parse(self.text)

    def test_each_sensor_gets_what_it_needs(self):
        for sensor in SENSORS:
            for action in ("add", "change", "bind"):
                with self.subTest(sensor=sensor, action=action):
                    given, final = play(self.rules, usb(*sensor, action=action))
                    self.assertEqual(given, {"GROUP": "plugdev", "MODE": "0660", "ATTR{power/control}": "on",
                                             "TAG": ["systemd"], "SYMLINK": ["cheval/sensor"]})
                    # OpenNI2's own rules would open it to everybody.
                    self.assertEqual(final, {"GROUP", "MODE"})

    def test_a_sensor_without_power_control_is_taken_as_it_is(self):
        device = usb(*SENSORS[0])
        del device["attr"]["power/control"]
        self.assertNotIn("ATTR{power/control}", play(self.rules, device)[0])

    def test_nothing_else_gets_anything(self):
        for other in OTHERS:
            with self.subTest(other=other):
                self.assertEqual(play(self.rules, usb(*other)), ({}, set()))
        self.assertEqual(play(self.rules, usb(*SENSORS[0], devtype="usb_interface")), ({}, set()))
        self.assertEqual(play(self.rules, usb(*SENSORS[0], action="remove")), ({}, set()))
        self.assertEqual(play(self.rules, {"action": "add", "subsystem": "block", "kernel": "sda"}), ({}, set()))

    def test_gpio_chips_are_for_their_group(self):
        device = {"action": "add", "subsystem": "gpio", "kernel": "gpiochip0"}
        self.assertEqual(play(self.rules, device)[0], {"GROUP": "gpio", "MODE": "0660"})

    def test_a_fault_would_be_told(self):
        for fault in ('SUBSYSTEM="usb", GROUP="plugdev"', 'GRUOP="plugdev"', 'GROUP=plugdev', 'GOTO="nowhere"'):
            with self.subTest(fault=fault), self.assertRaises(ValueError):
                parse(f"{self.text}\n{fault}\n")

    def test_it_comes_before_the_rules_of_openni(self):
        self.assertLess(RULES.rsplit("/", 1)[-1], "60-libopenni2-0.rules")


if __name__ == "__main__":
    RULES = sys.argv.pop(1)
    unittest.main(verbosity=2)
