"""Do the tests notice? Small faults are put into the code, and each package's own tests must fail."""
