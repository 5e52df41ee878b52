"""What is measured, apart from how it is shown: functions that return numbers, for suites, tests and stress runs."""
